// Dark or light: dark until the operator switches, remembered by the browser.
const KEY = "farhand-theme";

export class Theme {
  #button = document.getElementById("theme");
  #changed;

  /** `changed` is called after a switch: drawings take the page's colours. */
  constructor(changed) {
    this.#changed = changed;
    this.#button.addEventListener("click", () => this.#set(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    this.#set(localStorage.getItem(KEY) === "light" ? "light" : "dark");
  }

  #set(theme) {
    document.documentElement.dataset.theme = theme;
    localStorage.setItem(KEY, theme);
    this.#button.textContent = theme === "dark" ? "Light" : "Dark";
    this.#button.setAttribute("aria-label", `Switch to the ${theme === "dark" ? "light" : "dark"} page`);
    this.#changed();
  }
}
