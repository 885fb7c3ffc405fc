// A folder to begin in: what was found there, and the way from a board and two films to a study in five steps.
import { attempt, button, onClick, openPage, part, say, sayWhy, showJob } from "./dom";
import { FoundMessage, MakeQuestion, StartMessage, StateMessage } from "./messages";
import { server } from "./server";
import { TEXTS } from "./texts";

const OPENED = ["film", "trial", "comparison", "design", "study"]; // that have a page
const LISTED = [...OPENED, "problem", "camera", "study file", "result", "file"];

// Which kinds are offered, and whether one may do without.
const CHOICES: { [id: string]: { kinds: string[]; what: string; isOptional?: boolean } } = {
  "start-views": { kinds: ["film", "pictures"], what: "film or folder" },
  "start-plane": { kinds: ["picture"], what: "picture" },
  "start-human-film": { kinds: ["film"], what: "film" },
  "start-exo-film": { kinds: ["film"], what: "film" },
  "start-human": { kinds: ["trial"], what: "trial" },
  "start-exo": { kinds: ["trial"], what: "trial", isOptional: true },
  "start-worn": { kinds: ["design"], what: "design", isOptional: true },
  "start-problem": { kinds: ["problem"], what: "problem file", isOptional: true },
};

const valueOf = (id: string) => part<HTMLSelectElement | HTMLInputElement>(id).value;

export class StartPage {
  private isMaking = false;

  constructor(private start: StartMessage) {
    part("start").hidden = false;
    document.title = `${start.folder} – lake review`;
    part("name").textContent = start.folder;
    onClick("look-again", () => void this.look());
    onClick("make-camera", () => void this.make({
      what: "camera", views: valueOf("start-views"), board: valueOf("start-board"), plane: valueOf("start-plane"),
    }));
    onClick("make-study", () => void this.make({
      what: "study", name: valueOf("start-name"), human: valueOf("start-human"), exo: valueOf("start-exo"),
      worn: valueOf("start-worn"), mass_kg: Number(valueOf("start-mass")),
      problem: valueOf("start-problem"), percent: Number(valueOf("start-percent")),
      speed_mm_s: Number(valueOf("start-speed")), rise_s: Number(valueOf("start-rise")),
    }));
    onClick("track-human", () => void openPage(valueOf("start-human-film")));
    onClick("track-exo", () => void openPage(valueOf("start-exo-film")));
    onClick("open-report", () => void openPage(this.ofKind("study")[0].path));
    onClick("start-stop", () => void server.stop().catch(sayWhy));
    // A film that was tracked in another window is found when one comes back.
    window.addEventListener("focus", () => void this.look());
    this.show();
  }

  update(state: StateMessage): void {
    const { running, failed } = state.job!, was = this.isMaking;
    this.isMaking = running;
    showJob("start", state.job!, TEXTS.making);
    if (was === running) return;
    if (!running) say(failed ? TEXTS.notMade(failed) : TEXTS.made, failed !== "");
    this.show();
    if (!running) void this.look();
  }

  private look(): Promise<void> {
    return attempt(async () => {
      const start = await server.start();
      if (JSON.stringify(start) === JSON.stringify(this.start)) return; // a list that is open stays open
      this.start = start;
      this.show();
    });
  }

  private make(asked: MakeQuestion): Promise<void> {
    return attempt(async () => this.update(await server.make(asked)));
  }

  private ofKind(...kinds: string[]): FoundMessage[] {
    return this.start.found.filter((found) => kinds.includes(found.kind));
  }

  private show(): void {
    const { found } = this.start, listed = this.ofKind(...LISTED);
    part("state").textContent = TEXTS.foundCount(listed.length);
    for (const id of Object.keys(CHOICES)) this.fill(id);
    const trials = this.ofKind("trial").filter((trial) => trial.what !== "").map((trial) => trial.path);
    this.showStep("camera", found.filter(({ kind, lacks }) => kind === "camera" && lacks === "").map(({ path }) => path));
    this.showStep("human", trials.filter((path) => !this.isExo(path)));
    this.showStep("exo", trials.filter((path) => this.isExo(path)));
    this.showStep("study", this.ofKind("study file").map(({ path }) => path));
    this.showStep("report", this.ofKind("study").map(({ path }) => path));
    part<HTMLButtonElement>("make-camera").disabled = this.isMaking;
    part<HTMLButtonElement>("make-study").disabled = this.isMaking || trials.length === 0;
    part<HTMLButtonElement>("track-human").disabled = part<HTMLButtonElement>("track-exo").disabled = this.ofKind("film").length === 0;
    part<HTMLButtonElement>("open-report").disabled = this.ofKind("study").length === 0;
    part("found").replaceChildren(...listed.map((one) => this.line(one)));
  }

  private isExo(path: string): boolean {
    return this.start.found.some((found) => found.path === path && found.what.includes("exo_knee"));
  }

  private showStep(step: string, done: string[]): void {
    const line = part(`step-${step}`);
    line.querySelector(".done")!.textContent = done.map(TEXTS.done_step).join("  ");
    line.classList.toggle("is-done", done.length > 0);
  }

  // Keeps what was chosen; else proposes what a trial's markers say.
  private fill(id: string): void {
    const { kinds, what, isOptional } = CHOICES[id], select = part<HTMLSelectElement>(id), before = select.value;
    const offered = this.ofKind(...kinds).filter((found) => found.kind !== "trial" || found.what !== "");
    const first = new Option(isOptional ? TEXTS.without(what) : TEXTS.choose_one(what), "");
    select.replaceChildren(first, ...offered.map(({ path }) => new Option(path, path)));
    const proposed =
      id === "start-exo" ? offered.find(({ path }) => this.isExo(path))
      : id === "start-human" ? offered.find(({ path }) => !this.isExo(path))
      : id.endsWith("-film") ? offered.find(({ lacks }) => lacks !== "")
      : undefined;
    select.value = offered.some(({ path }) => path === before) ? before : proposed?.path ?? "";
  }

  private line(found: FoundMessage): HTMLElement {
    const line = document.createElement("li"), name = document.createElement("b"), detail = document.createElement("small");
    name.textContent = found.path;
    detail.textContent = [found.kind, found.what].filter((text) => text !== "").join(": ");
    line.append(name, detail);
    if (found.lacks) {
      const lacks = document.createElement("small");
      lacks.className = "lacks";
      lacks.textContent = found.lacks;
      line.append(lacks);
    }
    line.dataset.path = found.path;
    if (OPENED.includes(found.kind)) line.append(button(TEXTS.openFound, () => void openPage(found.path)));
    return line;
  }
}
