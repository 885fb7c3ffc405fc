// Opens what the server has: a folder to begin in, a tracked trial, a video whose markers are to be named, a design, a
// comparison, a study, a camera's session.
import { ComparisonPage } from "./comparison";
import { DesignPage } from "./design";
import { part, say, sayWhy } from "./dom";
import { LivePage } from "./live";
import { LiveStateMessage, StateMessage } from "./messages";
import { NamingPage } from "./naming";
import { server } from "./server";
import { StartPage } from "./start";
import { showStudy } from "./study";
import { TEXTS } from "./texts";
import { TrialPage } from "./trial";

const POLL_MS = 400;

let trial: TrialPage | null = null;
let naming: NamingPage | null = null;
let design: DesignPage | null = null;
let isShown = false; // what does not change
let start: StartPage | null = null;
let live: LivePage | null = null;
let isEnded = false;

async function update(state: StateMessage): Promise<void> {
  if (state.mode === "design") {
    design ??= new DesignPage(await server.design());
    design.update(state);
  } else if (state.mode === "comparison") {
    if (!isShown) new ComparisonPage(await server.comparison());
    isShown = true;
  } else if (state.mode === "study") {
    if (!isShown) showStudy(await server.study());
    isShown = true;
  } else if (state.mode === "start") {
    start ??= new StartPage(await server.start());
    start.update(state);
  } else if (state.mode === "live") {
    live ??= new LivePage(await server.live());
    live.update(state as LiveStateMessage);
  } else if (state.mode === "trial") {
    naming?.close();
    naming = null;
    if (trial) return trial.update(state);
    const message = await server.trial();
    say("");
    trial = new TrialPage(message);
  } else {
    naming ??= new NamingPage();
    naming.update(state);
  }
}

async function poll(): Promise<void> {
  try {
    const state = await server.state();
    if (isEnded && !live) location.reload();
    if (isEnded) say(""); // a busy computer lost an answer; the session has all the page shows
    isEnded = false;
    await update(state);
  } catch (why) {
    if (!(why instanceof TypeError)) return sayWhy(why);
    isEnded = true; // nobody answers
    say(live ? TEXTS.liveEnded : TEXTS.ended, true);
  }
}

part("state").textContent = TEXTS.loading;
void (async () => {
  for (;;) {
    await poll();
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
})();
