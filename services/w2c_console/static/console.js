// @ts-check
/** The page: wires camera, chat, stop and panels together. */

import { showAdvice } from "./advice.js";
import { Camera } from "./camera.js";
import { Chat } from "./chat.js";
import { Connection } from "./connection.js";
import { byId, shortId } from "./dom.js";
import { showPanels } from "./panels.js";
import { Stop } from "./stop.js";

/** First of all, and by itself: whatever fails below, Stop works. */
const stop = new Stop();

const confirmButton = byId("confirm", HTMLButtonElement);
/** Whether each stream is heard. */
const heard = { camera: false, news: false };
let everConnected = false;
let boot = "";
let lastEntry = 0;
let confirming = false;
/** @type {import("./panels.js").Target | null} */
let target = null;
/** @type {import("./advice.js").Advice | null} the last that was told, on whatever target */
let advice = null;

const camera = new Camera({
  point: (u, v, picture) => {
    const body = { u, v, ...picture };
    void chat.ask("/api/point", body, `(points at ${Math.round(u)}, ${Math.round(v)})`);
  },
  shown: showTarget,
  connected: (open) => setHeard("camera", open),
});

const chat = new Chat(() => ({
  ...camera.picture,
  target_id: camera.marker?.target_id ?? "",
}));

new Connection("/ws/news", {
  greet: (send) => send(JSON.stringify({ boot, after: lastEntry })),
  receive: (data) => receiveNews(JSON.parse(data)),
  change: (open) => setHeard("news", open),
});

confirmButton.addEventListener("click", async () => {
  const shown = camera.marker;
  if (shown === null || confirming) return;
  confirming = true;
  showTarget();
  await chat.ask("/api/confirm", { target_id: shown.target_id }, `(confirms ${shortId(shown.target_id)})`);
  confirming = false;
  showTarget();
});

/** @param {any} news */
function receiveNews(news) {
  if (news.type === "hello") {
    if (news.boot !== boot) {
      chat.clear();
      lastEntry = 0;
    }
    boot = news.boot;
    document.title = news.title;
    byId("title", HTMLElement).textContent = news.title;
    byId("robot-name", HTMLElement).textContent = news.robot;
  } else if (news.type === "panel") {
    target = news.target;
    showPanels(news);
    stop.follow(news.robot, news.controller);
    showTarget();
  } else if (news.type === "advice") {
    advice = news;
    showTarget();
  } else if (news.type === "area") {
    camera.area.take(news);
  } else {
    lastEntry = news.id;
    if (news.type === "turn") chat.showTurn(news);
    else chat.showGoal(news);
  }
}

/**
 * @param {"camera" | "news"} stream
 * @param {boolean} open
 */
function setHeard(stream, open) {
  if (heard[stream] === open && everConnected) return;
  heard[stream] = open;
  const connected = heard.camera && heard.news;
  everConnected ||= connected;
  const chip = byId("connection", HTMLElement);
  chip.dataset.level = connected ? "good" : everConnected ? "bad" : "busy";
  chip.textContent = connected ? "connected" : everConnected ? "connection lost – reconnecting" : "connecting";
  document.body.classList.toggle("offline", everConnected && !connected);
  showTarget();
}

/** Show the target of the picture; it can be confirmed only where it is seen. */
function showTarget() {
  const marker = camera.marker;
  const connected = heard.camera && heard.news;
  const said = marker?.state === "proposed" && advice?.target_id === marker.target_id ? advice : null;
  const vetoed = said !== null && said.refusal !== "";
  confirmButton.disabled =
    marker === null || marker.state !== "proposed" || !connected || confirming || vetoed;
  confirmButton.title = vetoed ? said.refusal : "";
  showAdvice(said);
  confirmButton.textContent = marker?.state === "proposed" ? `Confirm ${shortId(marker.target_id)}` : "Confirm";
  byId("target-going", HTMLElement).textContent =
    camera.movingTo === "" ? "" : `– the robot is moving to ${shortId(camera.movingTo)}`;
  const name = byId("target-name", HTMLElement);
  const words = byId("target-words", HTMLElement);
  const warning = byId("target-warning", HTMLElement);
  const known = target !== null && target.state !== "abandoned" ? target : null;
  if (known === null && marker === null) {
    name.textContent = "No target. Say where a hand should go.";
    words.textContent = "";
    warning.textContent = "";
    return;
  }
  const corrections = known?.corrections ?? 0;
  const corrected = corrections > 0 ? `, corrected ${corrections}×` : "";
  const id = shortId(marker?.target_id ?? known?.target_id ?? "");
  name.textContent = `Target ${id}: ${(marker ?? known)?.state.replace("_", " ")}${corrected}`;
  // Words and warning come by another stream: they are shown only with the target they belong to.
  const belongs = marker === null || known?.target_id === marker.target_id;
  words.textContent = belongs && known?.instruction ? `“${known.instruction}”` : "";
  warning.textContent = belongs && known !== null ? known.warning : "";
}
