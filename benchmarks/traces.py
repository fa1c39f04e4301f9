"""What the traces of an hour take on the disk, and of the time between touch and question.

A finger that holds 1 N and slides at 50 mm/s, for two seconds of each touch and 720 touches an hour, by sensors of
1 kHz that count 0.2 mN and 1 um; a texture of a second at 48 kHz and 16 bits. Tremor, drift and noise are drawn with
the sizes below (unverified defaults). Printed for each kind of samples, in one run: bytes of a touch, MB an hour,
milliseconds to keep it (median and 99th percentile), and how often the bytes and the time of ours numpy's compressed
archive takes, and numpy's gzipped text.
"""

import io
import tempfile
import time
from pathlib import Path

import numpy as np
from measured import tell

N_TOUCHES, TOUCHES_PER_HOUR = 100, 720
RATE_HZ, LASTS_S = 1000.0, 2.0
DRIFT_N, TREMOR_N, NOISE_N, COUNT_N = 0.05, 0.01, 0.002, 2e-4
WOBBLE_M, COUNT_M = 5e-6, 1e-6
CARD_HZ, FULL_SCALE_V = 48e3, 100.0


def stamps(rng, begin_s):
    n = round(RATE_HZ * LASTS_S)
    return begin_s + np.arange(n) / RATE_HZ + rng.normal(0.0, 2e-5, n)


def force(rng, begin_s):
    times_s = stamps(rng, begin_s)
    drift = np.cumsum(rng.normal(0.0, DRIFT_N / np.sqrt(len(times_s)), len(times_s)))
    tremor = TREMOR_N * np.sin(2 * np.pi * (10.0 * times_s + rng.uniform()))
    forces_n = 1.0 + drift + tremor + rng.normal(0.0, NOISE_N, len(times_s))
    return np.column_stack([times_s, np.rint(forces_n / COUNT_N) * COUNT_N])


def position(rng, begin_s):
    times_s = stamps(rng, begin_s)
    along_m = 0.05 * np.abs((times_s - begin_s) % 2.0 - 1.0)
    places_m = np.column_stack([along_m, np.full_like(along_m, 0.02)]) + rng.normal(0.0, WOBBLE_M, (len(times_s), 2))
    return np.column_stack([times_s, np.rint(places_m / COUNT_M) * COUNT_M])


def emitted(rng, begin_s):
    del begin_s
    times_s = np.arange(round(CARD_HZ)) / CARD_HZ
    share = 0.5 * (1 + np.tanh(20 * np.sin(2 * np.pi * (25 * times_s + rng.uniform()))))
    numbers = np.trunc(32767 * 0.5 * share * np.sin(2 * np.pi * 1000.0 * times_s))
    return (numbers / 32767 * FULL_SCALE_V)[:, None]


KINDS = {"force": (force, RATE_HZ), "position": (position, RATE_HZ), "emitted": (emitted, CARD_HZ)}


def archive(table, folder):
    file = io.BytesIO()
    np.savez_compressed(file, samples=table)
    (folder / "a.npz").write_bytes(file.getvalue())
    return len(file.getvalue())


def text(table, folder):
    np.savetxt(folder / "a.tsv.gz", table, fmt="%.9g", delimiter="\t")
    return (folder / "a.tsv.gz").stat().st_size


def timed(keep, tables):
    """Bytes, and seconds of each."""
    sizes, times_s = [], []
    for table in tables:
        begin_s = time.perf_counter()
        sizes.append(keep(table))
        times_s.append(time.perf_counter() - begin_s)
    return np.mean(sizes), np.array(times_s)


def main():
    from tactometry.records.data_set import Session
    from tactometry.records.traces import TraceFiles

    rng = np.random.default_rng(1)
    print("samples    bytes a touch  MB/h   keep ms (p50, p99)  archive: bytes, time   gzipped text: bytes, time")
    for kind, (make, rate_hz) in KINDS.items():
        tables = [make(rng, 5.0 * n) for n in range(N_TOUCHES)]
        with tempfile.TemporaryDirectory() as folder:
            files = TraceFiles(Path(folder), Session("P01", 1, "tutorial"))
            files.keep(kind, tables[0], rate_hz)  # the first makes the files
            size, times_s = timed(
                lambda table, files=files, kind=kind, rate=rate_hz: files.keep(kind, table, rate).n_bytes, tables
            )
            peers = [
                timed(lambda table, peer=peer, at=Path(folder): peer(table, at), tables) for peer in (archive, text)
            ]
            files.close()
        p50_ms, p99_ms = 1e3 * np.quantile(times_s, [0.5, 0.99])
        ratios = "   ".join(f"{of / size:8.2f} {np.median(s) / np.median(times_s):8.2f}" for of, s in peers)
        for name, (of, s) in zip(("numpy's compressed archive", "numpy's gzipped text"), peers, strict=True):
            tell(f"{kind}: bytes, {name} over ours", of / size)
            tell(f"{kind}: time by the clock, {name} over ours", np.median(s) / np.median(times_s))
        tell(f"{kind}: an hour", size * TOUCHES_PER_HOUR / 1e6, "MB")
        an_hour = size * TOUCHES_PER_HOUR / 1e6
        print(f"{kind:10} {size:13.0f} {an_hour:6.1f}   {p50_ms:8.2f} {p99_ms:8.2f}   {ratios}")


if __name__ == "__main__":
    main()
