// Dark or light: dark until the operator switches, remembered by the browser.
import { tagged } from "./elements.js";

const KEY = "farhand-theme";

export class Theme {
  #button = tagged("button", "theme");
  #changed;

  /** `changed` is called after a switch: drawings take the page's colours.
   * @param {() => void} changed */
  constructor(changed) {
    this.#changed = changed;
    this.#button.addEventListener("click", () => this.#set(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    this.#set(localStorage.getItem(KEY) === "light" ? "light" : "dark");
  }

  /** @type {(theme: "dark" | "light") => void} */
  #set(theme) {
    document.documentElement.dataset.theme = theme;
    localStorage.setItem(KEY, theme);
    this.#button.textContent = theme === "dark" ? "Light" : "Dark";
    this.#button.setAttribute("aria-label", `Switch to the ${theme === "dark" ? "light" : "dark"} page`);
    this.#changed();
  }
}
