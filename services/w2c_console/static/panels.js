// @ts-check
/** The state of robot, controller, recorder and processes. */

import { byId, duration, make } from "./dom.js";

/** Load of a full bar [N]: about the weight that one foot of a Talos carries. */
const FULL_LOAD = 600;
/** Phases in which the last goal is history. */
const RESTING = new Set(["starting", "hold", "held", "stopped"]);

/**
 * @typedef {{name: string, in_contact: boolean, load: number, desired_load: number}} Contact
 * @typedef {{
 *   age_s: number, stale: boolean, phase: string, message: string, goal_id: string, end_effector: string,
 *   task: string, distance: number, solver_failures: number, contacts: Contact[],
 *   lateness_us: Record<string, number>, tick_us: Record<string, number>,
 * }} Controller
 * @typedef {{age_s: number, stale: boolean, mode: string, stamp: string}} Robot
 * @typedef {{
 *   age_s: number, stale: boolean, recording: boolean, path: string, messages: number, bytes: number,
 *   lost: number, error: string,
 * }} Recorder
 * @typedef {{
 *   name: string, instance: string, phase: string, level: string, age_s: number | null,
 *   cpu_percent: number | null, memory_mb: number | null, restarts: number, lost: number, late: number, detail: string,
 * }} Process
 * @typedef {{target_id: string, state: string, instruction: string, corrections: number, warning: string}} Target
 * @typedef {{
 *   type: "panel", robot: Robot | null, controller: Controller | null, recorder: Recorder | null,
 *   target: Target | null, processes: Process[],
 * }} Panel
 */

/** @param {Panel} panel */
export function showPanels(panel) {
  byId("robot", HTMLElement).replaceChildren(...robotLines(panel.robot, panel.controller));
  byId("processes", HTMLElement).replaceChildren(...panel.processes.map(processRow));
  showRecorder(panel.recorder);
}

/**
 * @param {Robot | null} robot
 * @param {Controller | null} controller
 */
function robotLines(robot, controller) {
  const levels = { tracking: "good", holding: "busy", stopped: "bad" };
  const mode = robot === null ? "unknown" : robot.stale ? "silent" : robot.mode;
  const level = robot === null || robot.stale ? "absent" : (levels[/** @type {"tracking"} */ (mode)] ?? "busy");
  const chips = make("p", { class: "chips" }, chip("driver", mode, level));
  if (controller === null) {
    chips.append(chip("controller", "unknown", "absent"));
    return [chips];
  }
  const bad = controller.stale || controller.phase === "stopped" || controller.phase === "held";
  chips.append(chip("controller", controller.stale ? "silent" : controller.phase, bad ? "bad" : "good"));
  const lines = [chips];
  if (controller.stale) lines.push(make("p", { class: "warning" }, `last word ${duration(controller.age_s)} ago:`));
  if (controller.goal_id !== "" && !RESTING.has(controller.phase)) lines.push(make("p", {}, goalText(controller)));
  if (controller.message !== "") lines.push(make("p", { class: "message" }, controller.message));
  lines.push(make("div", { class: "contacts" }, ...controller.contacts.map(contactRow)));
  lines.push(make("p", { class: "muted timing" }, timingText(controller)));
  return lines;
}

/** @param {Controller} controller */
function goalText(controller) {
  const left = controller.distance >= 0 ? `, ${(controller.distance * 100).toFixed(1)} cm left` : "";
  return `${controller.end_effector.replace("_", " ")}: ${controller.task}${left}`;
}

/** @param {Controller} controller */
function timingText(controller) {
  const late = controller.lateness_us;
  const tick = controller.tick_us;
  const number = (/** @type {number | undefined} */ value) => (value === undefined ? "–" : value.toFixed(0));
  const parts = [
    `late p50 ${number(late.p50)} p99 ${number(late.p99)} max ${number(late.max)} µs`,
    `tick p50 ${number(tick.p50)} p99 ${number(tick.p99)} µs`,
    `gaps over 20 ms ${number(late.gaps_20ms)}`,
  ];
  if (controller.solver_failures > 0) parts.push(`solver failures ${controller.solver_failures}`);
  return parts.join(" · ");
}

/** @param {Contact} contact */
function contactRow(contact) {
  const bar = make("span", { class: "fill" });
  bar.style.width = `${Math.min(100, (Math.max(0, contact.load) / FULL_LOAD) * 100)}%`;
  const wish = make("span", { class: "wish" });
  wish.style.left = `${Math.min(100, (contact.desired_load / FULL_LOAD) * 100)}%`;
  const row = make(
    "div",
    { class: contact.in_contact ? "contact on" : "contact", role: "group", "aria-label": contact.name },
    make("span", { class: "name" }, lamp(contact.in_contact ? "good" : "absent"), contact.name),
    make("span", { class: "bar" }, bar, ...(contact.in_contact ? [wish] : [])),
    make("span", { class: "value" }, `${Math.round(contact.load) || 0} N`), // never "-0"
  );
  row.title = `measured ${contact.load.toFixed(1)} N, desired ${contact.desired_load.toFixed(1)} N`;
  return row;
}

/** @param {Process} process */
function processRow(process) {
  const name = process.instance === "0" ? process.name : `${process.name} ${process.instance}`;
  const phase = make("td", {}, process.phase);
  const notes = [];
  if (process.restarts > 0) notes.push(`restarted ${process.restarts}×`);
  if (process.lost > 0) notes.push(`${process.lost} lost`);
  if (process.late > 0) notes.push(`${process.late}× late`);
  if (notes.length > 0) phase.append(make("small", { class: "warning" }, notes.join(", ")));
  if (process.level === "bad" && process.detail !== "") phase.append(make("small", {}, process.detail));
  const memory = process.memory_mb === null ? "" : `, ${process.memory_mb.toFixed(0)} MB`;
  return make(
    "tr",
    { "data-level": process.level, title: `${process.detail || process.phase}${memory}` },
    make("th", { scope: "row" }, lamp(process.level), name),
    phase,
    make("td", { class: "number" }, process.cpu_percent === null ? "" : `${process.cpu_percent.toFixed(0)} %`),
    make("td", { class: "number" }, process.age_s === null ? "–" : `${process.age_s.toFixed(1)} s`),
  );
}

/** @param {Recorder | null} recorder */
function showRecorder(recorder) {
  const element = byId("recorder", HTMLElement);
  element.className = "recorder";
  if (recorder === null || recorder.stale) {
    element.replaceChildren(lamp("absent"), recorder === null ? "no recorder" : "recorder is silent");
    return;
  }
  const level = recorder.error !== "" || recorder.lost > 0 ? "bad" : recorder.recording ? "recording" : "absent";
  const size = `${recorder.messages.toLocaleString("en")} messages, ${(recorder.bytes / 1e6).toFixed(1)} MB`;
  const lost = recorder.lost > 0 ? `, ${recorder.lost} lost` : "";
  const text = recorder.error !== "" ? recorder.error : `${size}${lost}`;
  const state = recorder.recording ? "recording" : "not recording";
  element.replaceChildren(lamp(level), `${state} · ${text}`, make("small", {}, recorder.path));
}

/**
 * @param {string} name
 * @param {string} text
 * @param {string} level
 */
function chip(name, text, level) {
  return make("span", { class: "chip", "data-level": level }, make("small", {}, name), text);
}

/** @param {string} level */
function lamp(level) {
  return make("i", { class: "lamp", "data-level": level, "aria-hidden": "true" });
}
