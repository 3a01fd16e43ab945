// The list of events, newest first; folded away, its newest line stays in sight.
import { put } from "./words.js";

export class EventList {
  #events = document.getElementById("events");
  #newest = document.getElementById("newest-event");

  show({ events }) {
    put(this.#newest, events.length > 0 ? events[0].text : "none yet");
    while (this.#events.children.length > events.length) this.#events.lastChild.remove();
    while (this.#events.children.length < events.length) this.#events.append(emptyEvent());
    events.forEach((event, k) => fill(this.#events.children[k], event));
  }
}

function emptyEvent() {
  const item = document.createElement("li");
  item.append(document.createElement("time"), document.createElement("span"));
  return item;
}

function fill(item, event) {
  put(item.firstChild, event.ago_ms < 1000 ? "now" : `${Math.floor(event.ago_ms / 1000)} s`);
  if (item.dataset.number === String(event.number)) return;
  item.dataset.number = event.number;
  item.dataset.kind = event.kind;
  item.lastChild.textContent = event.text;
}
