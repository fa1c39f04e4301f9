"""From a device to stamped samples: the seams, the reader thread, calibration, the sources."""
