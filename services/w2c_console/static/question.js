// @ts-check
/** The question that is open: its answers as buttons, until the conversation goes on. */

import { make } from "./dom.js";

export class Question {
  /** @param {(text: string) => boolean} say says an answer as if it was typed; false where it cannot now */
  constructor(say) {
    this.say = say;
    this.text = "";
    /** @type {HTMLElement | null} */
    this.answers = null;
  }

  /**
   * Follow the conversation. What leads on closes a question, and so does another one. What the robot reports by
   * itself, a stop, and words that were not understood leave it open.
   * @param {import("./chat.js").Turn} turn
   * @param {HTMLElement} item where the turn is shown
   */
  follow(turn, item) {
    if (turn.options.length > 0) {
      this.close();
      this.text = turn.reply;
      const buttons = turn.options.map((option) => this.button(option));
      this.answers = make("div", { class: "answers", role: "group", "aria-label": "Answers" }, ...buttons);
      item.append(this.answers);
    } else if (turn.ok && turn.module !== "none") {
      this.close();
    } else if (this.answers !== null && turn.reply.includes(this.text)) {
      item.append(this.answers); // the question was put again, here
    }
  }

  close() {
    this.answers?.remove();
    this.answers = null;
  }

  /** @param {string} option */
  button(option) {
    const button = make("button", { type: "button" }, option);
    button.addEventListener("click", (event) => {
      // Who works with keys goes on with them: the button is about to vanish.
      if (this.say(option) && event.detail === 0) document.getElementById("say")?.focus();
    });
    return button;
  }
}
