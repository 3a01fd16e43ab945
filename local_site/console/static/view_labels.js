// The words on a view: its number and name, how old its picture is and how often one comes, and what is drawn or wrong.
import { put } from "./words.js";

export class ViewLabels {
  #name = label("name");
  #age = label("age");
  #rate = label("rate");
  #fresh = label("fresh", this.#age, this.#rate);
  #trouble = label("trouble");
  #explains = label("explains");

  constructor() {
    this.complain("");
    this.explain(false);
    put(this.#explains, "violet: the arm as commanded");
  }

  get elements() {
    return [this.#trouble, this.#name, this.#explains, this.#fresh];
  }

  /** `key` is the number that makes the view large; one of the operator has none.
   * @type {(key: number | null, name: string) => void} */
  call(key, name) {
    put(this.#name, `${key ?? ""} ${name.replaceAll("_", " ")}`.trim());
  }

  /** Words for the picture's age, and for how many come a second, empty where that says nothing.
   * @type {(age: string, rate: string) => void} */
  tell(age, rate) {
    put(this.#age, age);
    put(this.#rate, rate);
  }

  /** Whether the violet ghost, which the words explain, is drawn.
   * @type {(isDrawn: boolean) => void} */
  explain(isDrawn) {
    this.#explains.hidden = !isDrawn;
  }

  /** Say what is wrong with all pictures, on this one; empty words say nothing.
   * @type {(words: string) => void} */
  complain(words) {
    put(this.#trouble, words);
    this.#trouble.hidden = words === "";
  }
}

/** @type {(kind: string, ...parts: Node[]) => HTMLElement} */
function label(kind, ...parts) {
  const made = document.createElement("span");
  made.className = kind;
  made.append(...parts);
  return made;
}
