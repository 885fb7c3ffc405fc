// Opens what the server has: a tracked trial, or a video whose markers are to be named.
import { part, say, sayWhy } from "./dom";
import { StateMessage } from "./messages";
import { NamingPage } from "./naming";
import { server } from "./server";
import { TEXTS } from "./texts";
import { TrialPage } from "./trial";

const POLL_MS = 400;

let trial: TrialPage | null = null;
let naming: NamingPage | null = null;
let isEnded = false;

async function update(state: StateMessage): Promise<void> {
  if (state.mode === "trial") {
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
    if (isEnded) location.reload();
    await update(state);
  } catch (why) {
    if (!(why instanceof TypeError)) return sayWhy(why);
    isEnded = true; // nobody answers
    say(TEXTS.ended, true);
  }
}

part("state").textContent = TEXTS.loading;
void (async () => {
  for (;;) {
    await poll();
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
})();
