// The list of events, newest first; folded away, its newest line stays in sight.
/** @import { Event, Situation } from "../model/messages.d.ts" */
import { element } from "./elements.js";
import { mark, put } from "./words.js";

export class EventList {
  #events = element("events");
  #newest = element("newest-event");

  /** @type {(situation: Situation) => void} */
  show({ events }) {
    put(this.#newest, events.length > 0 ? events[0].text : "none yet");
    while (this.#events.children.length > events.length) this.#events.lastChild?.remove();
    while (this.#events.children.length < events.length) this.#events.append(emptyEvent());
    events.forEach((event, k) => fill(this.#events.children[k], event));
  }
}

function emptyEvent() {
  const item = document.createElement("li");
  item.append(document.createElement("time"), document.createElement("span"));
  return item;
}

/** @type {(item: Element, event: Event) => void} */
function fill(item, event) {
  const [ago, text] = item.children;
  put(ago, event.ago_ms < 1000 ? "now" : `${Math.floor(event.ago_ms / 1000)} s`);
  mark(item, "data-number", event.number);
  mark(item, "data-kind", event.kind);
  put(text, event.text);
}
