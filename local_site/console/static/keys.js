// Keys that press buttons: each acts only while its button is shown and enabled. Esc, which always stops, is none of them.

/** Whether a person could press it now.
 * @type {(button: HTMLButtonElement) => boolean} */
export const canPress = (button) => button.checkVisibility() && !button.disabled;

/** Whether an event is a key pressed by itself, once.
 * @type {(event: KeyboardEvent) => boolean} */
export const isPlain = (event) => !(event.ctrlKey || event.altKey || event.metaKey || event.repeat);

/** Have keys press buttons; `buttons` has one for each small letter.
 * @type {(buttons: Record<string, HTMLButtonElement>) => void} */
export function pressByKey(buttons) {
  addEventListener("keydown", (event) => {
    const button = buttons[event.key.toLowerCase()];
    if (button !== undefined && isPlain(event) && canPress(button)) button.click();
  });
}
