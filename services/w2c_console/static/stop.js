// @ts-check
/** Stop and resume. Needs nothing but the server: no stream, no other module's state. */

import { RequestError, post, send } from "./api.js";
import { byId, make, timeOfDay } from "./dom.js";

const STOP_MS = 5000;
const RESUME_MS = 10_000;
/** A state this much younger than the acknowledgement [ns] was surely made after it. */
const SETTLE_NS = 100_000_000n;
/** A state may come this much later than it was made [ns]; what is older is of another robot time. */
const LATE_NS = 5_000_000_000n;

/**
 * @typedef {{
 *   acknowledged: boolean, mode: string, stamp: string, line: string, controller: string,
 *   failures: string[], seconds: number, time_ms: number,
 * }} Outcome
 */

export class Stop {
  constructor() {
    this.status = byId("stop-status", HTMLElement);
    this.resumeButton = byId("resume", HTMLButtonElement);
    this.underWay = 0;
    /** @type {bigint | null} robot time of the last acknowledgement [ns] */
    this.heldSince = null;
    /** @type {bigint | null} robot time of the last resume [ns] */
    this.resumedAt = null;
    byId("stop-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      void this.stop();
    });
    this.resumeButton.addEventListener("click", () => void this.resume());
    addEventListener("keydown", (event) => this.key(event), { capture: true });
    addEventListener("keyup", (event) => this.key(event), { capture: true });
  }

  async stop() {
    this.underWay += 1;
    this.show("busy", "stopping …", "");
    try {
      const response = await send("/api/stop", null, STOP_MS);
      /** @type {Outcome | null} */
      const outcome = await response.json().catch(() => null);
      if (outcome?.acknowledged === true) this.acknowledged(outcome);
      else this.failed(outcome?.failures?.join("; ") ?? `the console answered ${response.status}`, outcome);
    } catch (error) {
      if (!(error instanceof RequestError)) throw error;
      this.failed(error.message, null);
    } finally {
      this.underWay -= 1;
    }
  }

  /** @param {Outcome} outcome */
  acknowledged(outcome) {
    this.heldSince = BigInt(outcome.stamp);
    const controller = outcome.controller === "acknowledged" ? "" : ` · controller: ${outcome.controller}`;
    const detail = `${Math.round(outcome.seconds * 1000)} ms via ${outcome.line}${controller}`;
    this.show("held", `holding (acknowledged at ${timeOfDay(outcome.time_ms)})`, detail);
    this.resumeButton.hidden = false;
  }

  /**
   * @param {string} reason
   * @param {Outcome | null} outcome
   */
  failed(reason, outcome) {
    this.heldSince = null;
    const controller = outcome?.controller === "acknowledged" ? "The controller alone holds. " : "";
    this.show("failed", "STOP NOT DELIVERED", `${controller}${reason}`);
  }

  async resume() {
    this.resumeButton.disabled = true;
    try {
      const answer = await post("/api/resume", null, RESUME_MS);
      this.heldSince = null;
      this.resumedAt = BigInt(answer.stamp);
      this.resumeButton.hidden = true;
      this.show("", `resumed (${answer.mode})`, "");
    } catch (error) {
      if (!(error instanceof RequestError)) throw error;
      this.show("held", "still holding: resume was not done", error.message);
    } finally {
      this.resumeButton.disabled = false;
    }
  }

  /**
   * Follow what the robot says of itself: someone else may have stopped or resumed it. A controller
   * that holds for a reason of its own asks for the same button.
   * @param {{mode: string, stamp: string, stale: boolean} | null} robot
   * @param {{phase: string, stale: boolean, message: string} | null} controller
   */
  follow(robot, controller) {
    if (robot === null || robot.stale || this.underWay > 0 || this.isOfBeforeResume(robot)) return;
    if (controller !== null && !controller.stale && controller.phase === "held") {
      this.resumeButton.hidden = false;
      this.show("held", "holding (the controller)", controller.message);
    } else if (robot.mode === "stopped") {
      this.resumeButton.hidden = false;
      if (this.status.dataset.level !== "held") this.show("held", "holding (stopped)", "");
    } else if (this.status.dataset.level === "held" && BigInt(robot.stamp) > (this.heldSince ?? 0n) + SETTLE_NS) {
      this.resumeButton.hidden = true;
      this.show("", "", "");
    }
  }

  /**
   * A state from before the resume may come after the answer to it: it would say "holding" once more.
   * @param {{stamp: string}} robot
   */
  isOfBeforeResume(robot) {
    if (this.resumedAt === null) return false;
    const age = this.resumedAt - BigInt(robot.stamp);
    return age >= 0n && age < LATE_NS;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
    if (event.key !== "Escape" && (event.key !== " " || typing)) return;
    // On both edges: Space must not press the button that has the focus, least of all Confirm.
    event.preventDefault();
    event.stopImmediatePropagation();
    if (event.type === "keydown" && !event.repeat) void this.stop();
  }

  /**
   * @param {"" | "busy" | "held" | "failed"} level
   * @param {string} text
   * @param {string} detail
   */
  show(level, text, detail) {
    this.status.dataset.level = level;
    this.status.replaceChildren(...(text === "" ? [] : [text, make("small", {}, detail)]));
  }
}
