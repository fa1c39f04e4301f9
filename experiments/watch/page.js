"use strict";
// The server sends the sections that changed; everything else is HTML that it made.
const lost = document.getElementById("lost");
const source = new EventSource("events");

source.onmessage = (event) => {
  lost.textContent = "";
  for (const [id, html] of Object.entries(JSON.parse(event.data))) {
    document.getElementById(id).innerHTML = html;
  }
  tellSince();
};

source.onerror = () => {
  lost.textContent = "No connection: tactometry watch has ended or does not respond. This page may be outdated.";
};

function tellSince() {
  for (const place of document.querySelectorAll("[data-written-s]")) {
    const written = Number(place.dataset.writtenS);
    const since = Math.max(0, Math.round(Date.now() / 1000 - written));
    place.textContent = written ? `journal written ${since < 120 ? `${since} s` : `${Math.round(since / 60)} min`} ago` : "";
  }
}

setInterval(tellSince, 1000);
tellSince();
