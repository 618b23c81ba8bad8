// @ts-check
/** The conversation: what was said, what was answered, what the robot did about it. */

import { RequestError, post } from "./api.js";
import { byId, duration, make, shortId, timeOfDay } from "./dom.js";
import { Question } from "./question.js";

const ANSWER_MS = 125_000;
/** What the operator did where nothing was said, by the module that answered. */
const WORDLESS = /** @type {Record<string, string>} */ ({ point: "(points)", confirmation: "(confirms)" });

/**
 * @typedef {{
 *   type: "turn", id: number, key: string, time_ms: number, text: string, reply: string, ok: boolean,
 *   module: string, options: string[], target_id: string, seconds: number, steps: Record<string, number>,
 * }} Turn
 * @typedef {{
 *   type: "goal", id: number, time_ms: number, goal_id: string, end_effector: string, task: string,
 *   state: string, reason: string, distance: number,
 * }} Goal
 */

export class Chat {
  /** @param {() => {frame_stamp: string, robot_boot: string, target_id: string}} onScreen what the operator sees */
  constructor(onScreen) {
    this.onScreen = onScreen;
    this.question = new Question((text) => this.say(text));
    this.list = byId("chat", HTMLOListElement);
    this.input = byId("say", HTMLInputElement);
    this.sendButton = byId("send", HTMLButtonElement);
    /** @type {Set<string>} turns that are shown: each comes as an answer and as news */
    this.shown = new Set();
    /** @type {Map<string, HTMLElement>} what was asked and not yet answered, by its text */
    this.pending = new Map();
    byId("say-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      const text = this.input.value.trim();
      if (text !== "" && this.say(text)) this.input.value = "";
    });
  }

  /**
   * Say something about what is on the screen.
   * @param {string} text
   * @returns {boolean} false while an earlier request is not answered
   */
  say(text) {
    if (this.sendButton.disabled) return false;
    void this.ask("/api/say", { text, ...this.onScreen() }, text);
    return true;
  }

  /**
   * Send a request that is answered by a turn, and show what becomes of it.
   * @param {string} path
   * @param {object} body
   * @param {string} text what the operator did, in words
   */
  async ask(path, body, text) {
    this.sendButton.disabled = true;
    const waiting = make("p", { class: "bubble reply waiting" }, "…");
    const item = make("li", { class: "turn" }, make("p", { class: "bubble said" }, text), waiting);
    this.pending.set(text, item);
    this.append(item);
    try {
      this.showTurn({ ...(await post(path, body, ANSWER_MS)), type: "turn" });
    } catch (error) {
      if (!(error instanceof RequestError)) throw error;
      waiting.className = "bubble reply failed";
      waiting.replaceChildren(
        make("strong", {}, error.code === "refused" ? "Refused. " : "Not done. "),
        error.message,
      );
      this.pending.delete(text);
      this.scrollToEnd();
    } finally {
      this.pending.get(text)?.remove();
      this.pending.delete(text);
      this.sendButton.disabled = false;
    }
  }

  /** Forget everything: the server tells it anew. */
  clear() {
    this.list.replaceChildren(...this.pending.values());
    this.shown.clear();
    this.question.close();
  }

  /** @param {Turn} turn */
  showTurn(turn) {
    if (this.shown.has(turn.key)) return;
    this.shown.add(turn.key);
    this.pending.get(turn.text)?.remove();
    this.pending.delete(turn.text);
    const said = turn.text || (WORDLESS[turn.module] ?? "");
    const parts = Object.entries(turn.steps).map(([name, seconds]) => `${name} ${duration(seconds)}`);
    const about = [timeOfDay(turn.time_ms), turn.module, shortId(turn.target_id), duration(turn.seconds)];
    const meta = make("p", { class: "meta" }, about.filter((part) => part !== "").join(" · "));
    if (parts.length > 0) meta.append(make("span", { class: "steps" }, parts.join(" · ")));
    const failed = !turn.ok && turn.options.length === 0;
    const item = make(
      "li",
      { class: "turn" },
      ...(said === "" ? [] : [make("p", { class: "bubble said" }, said)]),
      make("p", { class: failed ? "bubble reply failed" : "bubble reply" }, turn.reply),
      meta,
    );
    this.append(item, () => this.question.follow(turn, item));
  }

  /** @param {Goal} goal */
  showGoal(goal) {
    const bad = goal.state === "unreachable" || goal.state === "aborted";
    const distance = goal.distance >= 0 ? `, ${(goal.distance * 100).toFixed(1)} cm left` : "";
    const reason = goal.reason === "" ? "" : `: ${goal.reason}`;
    this.append(
      make(
        "li",
        { class: `goal ${bad ? "failed" : goal.state}`, title: `${goal.goal_id}, ${timeOfDay(goal.time_ms)}` },
        make("strong", {}, `${goal.end_effector} ${goal.state}`),
        `${distance}${reason}`,
      ),
    );
  }

  /**
   * @param {HTMLElement} item
   * @param {() => void} complete what else changes with it, before the list scrolls
   */
  append(item, complete = () => {}) {
    const atEnd = this.list.scrollHeight - this.list.scrollTop - this.list.clientHeight < 80;
    this.list.append(item);
    complete();
    if (atEnd) this.scrollToEnd();
  }

  scrollToEnd() {
    this.list.scrollTop = this.list.scrollHeight;
  }
}
