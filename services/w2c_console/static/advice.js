// @ts-check
/** What speaks for and against the target on the screen. */

import { byId, make } from "./dom.js";

/**
 * @typedef {{kind: string, level: string, text: string, numbers: string}} Remark
 * @typedef {{
 *   type: "advice", target_id: string, refusal: string, remarks: Remark[], unchecked: string[], pending: boolean,
 * }} Advice
 */

/** What is drawn: it is drawn anew only when it changes, so that what was unfolded stays so. */
let drawn = "";

/**
 * Show advice, or clear it away.
 * @param {Advice | null} advice on the target that is seen
 */
export function showAdvice(advice) {
  const text = JSON.stringify(advice);
  if (text === drawn) return;
  drawn = text;
  byId("advice", HTMLElement).replaceChildren(...(advice === null ? [] : lines(advice)));
}

/**
 * @param {Advice} advice
 * @returns {HTMLElement[]}
 */
function lines(advice) {
  const items = advice.remarks.map((remark) =>
    make(
      "li",
      { class: `remark ${remark.level}`, role: "listitem", "aria-label": `${remark.level}: ${remark.kind}` },
      make("span", {}, remark.text),
      ...(remark.numbers === "" ? [] : [make("small", {}, ` ${remark.numbers}`)]),
    ),
  );
  if (advice.pending) items.push(make("li", { class: "remark pending" }, "looking closer …"));
  const found = items.length === 0 ? [] : [make("ul", {}, ...items)];
  return advice.unchecked.length === 0 ? found : [...found, unchecked(advice.unchecked)];
}

/** @param {string[]} reasons */
function unchecked(reasons) {
  const count = reasons.length === 1 ? "1 check was" : `${reasons.length} checks were`;
  const items = reasons.map((reason) => make("li", {}, reason));
  return make("details", {}, make("summary", {}, `${count} not made in full`), make("ul", {}, ...items));
}
