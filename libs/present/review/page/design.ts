// A design: links changed by sliders, numbers and dragged pins; the server says at once what becomes of it.
import { Chart, Curve } from "./charts";
import { attempt, button, copyText, isOfControl, item, onClick, onKey, part, say, sayWhy, showProgress, undoOf } from "./dom";
import { LinkageView } from "./linkage";
import {
  CheckMessage, DesignColumns, DesignMessage, ExploreQuestion, ExploredMessage, PinName, Place, PoseMessage, StateMessage,
} from "./messages";
import { Player } from "./player";
import { server } from "./server";
import { TEXTS } from "./texts";

const LINK_COLOURS = ["--l1", "--l2", "--l3", "--l4", "--l3", "--l3"];
const ROWS = 181; // of the server's curves
const PLAY_MS = 25;
const REST_MS = 150; // after the last change
const ONE_STEP_MS = 1000; // changes of one slider that follow each other sooner are one step

export class DesignPage {
  private links: number[];
  private past: number[][] = [];
  private future: number[][] = [];
  private explored: ExploredMessage | null = null;
  private row = 0;
  private exact: { stroke: number; pose: PoseMessage } | null = null; // that a pin was dragged in, between two rows
  private pending: ExploreQuestion | null = null;
  private isAsking = false;
  private isDragging = false;
  private isAskingBuilds = false;
  private slid = { link: -1, at: 0 }; // the slider that was moved last, and when
  private startedOptimum: number | null = null; // the number of the last one when this window asked for another
  private player = new Player("design-play", PLAY_MS, () => this.standingUpAndSittingDown());
  private view: LinkageView;
  private sliders: { range: HTMLInputElement; number: HTMLInputElement; label: HTMLElement }[] = [];
  private charts: { theta: Chart; arm: Chart; force: Chart };

  constructor(private about: DesignMessage) {
    part("design").hidden = false;
    part("name").textContent = about.name;
    document.title = `${about.name} – lake review`;
    part("limits").textContent = about.limits;
    part("design-notes").replaceChildren(...about.notes.map(item));
    this.links = linksOfAddress() ?? [...about.links];
    this.view = new LinkageView(part("linkage"), about.body, {
      drag: (pin, to) => this.drag(pin, to),
      drop: () => {
        this.isDragging = false;
        this.showCommand();
      },
    });
    const seek = (row: number) => this.seek(row);
    this.charts = {
      theta: new Chart(part("theta-chart"), ROWS, seek),
      arm: new Chart(part("arm-chart"), ROWS, seek),
      force: new Chart(part("force-chart"), ROWS, seek),
    };
    this.makeSliders();
    this.connect();
    this.ask({ links: this.links });
    this.showCommand();
  }

  update(state: StateMessage): void {
    const { running, progress, failed } = state.job!, bar = part<HTMLProgressElement>("design-progress");
    if (running) showProgress(bar, progress);
    bar.hidden = part("design-stop").hidden = !running;
    part<HTMLButtonElement>("optimise").disabled = running;
    if (running) return say(progress || TEXTS.optimising);
    if (this.startedOptimum === null) return;
    const number = state.optimum?.number ?? 0;
    if (number > this.startedOptimum) {
      this.change(state.optimum!.links);
      say(TEXTS.optimised);
    } else {
      say(TEXTS.optimiseFailed(failed), true);
    }
    this.startedOptimum = null;
  }

  // --- links

  private makeSliders(): void {
    this.sliders = this.links.map((_, link) => {
      const name = document.createElement("span"), label = document.createElement("label"), short = document.createElement("b");
      const range = document.createElement("input"), number = document.createElement("input");
      const [lower, upper] = this.about.bounds[link];
      short.textContent = `l${link + 1}`;
      name.append(short, ` ${TEXTS.links[link]}, ${TEXTS.bounds(lower, upper)}`);
      name.className = "name";
      range.type = "range";
      number.type = "number";
      number.step = range.step = "0.1";
      range.setAttribute("aria-label", `l${link + 1}`);
      label.style.setProperty("--link", `var(${LINK_COLOURS[link]})`);
      label.dataset.link = String(link + 1);
      label.append(name, range, number);
      range.addEventListener("pointerdown", () => (this.slid.link = -1));
      range.addEventListener("input", () => {
        this.rememberSlide(link);
        this.setLink(link, Number(range.value));
      });
      range.addEventListener("change", () => this.showCommand());
      number.setAttribute("aria-label", `l${link + 1} (mm)`);
      number.addEventListener("blur", () => this.showLinks());
      number.addEventListener("change", () => {
        if (!(Number(number.value) > 0)) return; // nothing, or not yet a length
        this.remember();
        this.setLink(link, Number(number.value));
        this.showCommand();
      });
      return { range, number, label };
    });
    part("links").replaceChildren(...this.sliders.map(({ label }) => label));
    this.showLinks();
  }

  private showLinks(): void {
    this.sliders.forEach(({ range, number, label }, link) => {
      const [lower, upper] = this.about.bounds[link], value = this.links[link];
      // As far as the bounds, and further where the link is.
      range.min = String(Math.min(lower, Math.floor(value)));
      range.max = String(Math.max(upper, Math.ceil(value)));
      range.value = String(value);
      if (document.activeElement !== number) number.value = value.toFixed(2);
      label.classList.toggle("outside", value < lower - 1e-6 || value > upper + 1e-6);
    });
    part<HTMLButtonElement>("design-undo").disabled = this.past.length === 0;
    part<HTMLButtonElement>("design-redo").disabled = this.future.length === 0;
    // So that the page can be loaded again, and the address be kept.
    history.replaceState(null, "", `#${this.links.map((length) => Number(length.toFixed(4))).join()}`);
  }

  private remember(): void {
    const last = this.past[this.past.length - 1];
    if (last && last.every((length, link) => length === this.links[link])) return;
    this.past.push([...this.links]);
    this.future = [];
  }

  // A slide is one step, however far it goes, by pointer or by keys.
  private rememberSlide(link: number): void {
    const now = performance.now(), isSame = this.slid.link === link && now - this.slid.at < ONE_STEP_MS;
    this.slid = { link, at: now };
    if (!isSame) this.remember();
  }

  private setLink(link: number, length: number): void {
    this.links = this.links.map((old, other) => (other === link ? length : old));
    this.ask({ links: this.links });
  }

  private change(links: number[]): void {
    this.remember();
    this.go(links);
  }

  private go(links: number[]): void {
    this.links = [...links];
    this.ask({ links: this.links });
    this.showCommand();
  }

  private step(from: number[][], to: number[][], said: string): void {
    const links = from.pop();
    if (!links) return;
    to.push([...this.links]);
    this.slid.link = -1;
    this.go(links);
    this.sliders.forEach(({ number }, link) => (number.value = links[link].toFixed(2)));
    say(said);
  }

  private drag(pin: PinName, to: Place): void {
    const curves = this.explored?.curves;
    if (!curves) return;
    if (!this.isDragging) this.remember();
    this.isDragging = true;
    this.ask({ links: this.links, drag: { pin, x: to[0], y: to[1], stroke: this.exact?.stroke ?? curves.stroke[this.row] } });
  }

  // One question at a time; of those that come meanwhile the last counts. What was said is of the links before.
  private ask(question: ExploreQuestion): void {
    say("");
    this.pending = question;
    this.showLinks();
    if (!this.isAsking) void this.askPending();
  }

  private async askPending(): Promise<void> {
    this.isAsking = true;
    while (this.pending) {
      const question = this.pending;
      this.pending = null;
      try {
        this.take(await server.explore(question));
      } catch (why) {
        this.showNothing();
        sayWhy(why);
      }
    }
    this.isAsking = false;
    if (this.about.tolerance_mm !== null) void this.followWithBuilds();
  }

  // All builds within a tolerance take a second, for which a slide does not wait: they follow once the links rest.
  private async followWithBuilds(): Promise<void> {
    if (this.isAskingBuilds) return;
    this.isAskingBuilds = true;
    for (let links: number[] | null = null; links !== this.links; ) {
      links = this.links;
      await new Promise((rested) => setTimeout(rested, REST_MS));
      if (links !== this.links || this.isAsking) continue;
      try {
        const { checks, of_builds } = await server.explore({ links, builds: true });
        if (links === this.links && this.explored) this.explored = { ...this.explored, checks, of_builds };
        this.showChecks();
      } catch (why) {
        sayWhy(why);
      }
    }
    this.isAskingBuilds = false;
  }

  // --- what is shown

  private take(explored: ExploredMessage): void {
    const isFirst = !this.explored || (!this.explored.curves && explored.curves);
    this.explored = explored;
    if (explored.stroke !== null) this.links = explored.links;
    this.showLinks();
    this.showChecks();
    const { curves } = explored;
    if (curves && explored.stroke !== null) this.row = nearestRow(curves.stroke, explored.stroke);
    const exact = explored.stroke !== null && explored.pose ? { stroke: explored.stroke, pose: explored.pose } : null;
    for (const id of ["theta-chart", "arm-title", "arm-chart", "force-title", "force-chart"]) part(id).hidden = !curves;
    this.charts.theta.show(this.curves((columns) => columns.knee));
    this.charts.arm.show(this.curves((columns) => columns.arm));
    this.charts.force.show(this.curves((columns) => columns.force));
    part("theta-title").textContent = curves ? TEXTS.kneeOverStroke(curves.stroke[0], curves.stroke[ROWS - 1]) : TEXTS.noCurves;
    part("arm-title").textContent = TEXTS.arm;
    part("force-title").textContent = TEXTS.force(this.about.torque_nm);
    this.seek(this.row, exact);
    if (isFirst) this.fit();
    part("design").dataset.range = String(explored.range_deg);
  }

  // Of links that nobody could say anything of: what was said of others does not stay.
  private showNothing(): void {
    part("state").textContent = TEXTS.unknown;
    part("state").classList.add("error");
    part("check-count").textContent = "";
    part("checks").replaceChildren();
  }

  private curves(pick: (columns: DesignColumns) => Curve["values"]): Curve[] {
    const curves = this.explored?.curves;
    if (!curves) return [];
    const isChanged = this.links.some((length, link) => Math.abs(length - this.about.links[link]) > 1e-6);
    const saved: Curve = { name: TEXTS.saved_design, colour: "--quiet", values: pick(curves.saved) };
    return [...(isChanged ? [saved] : []), { name: TEXTS.now, colour: "--accent", values: pick(curves.now) }];
  }

  private showChecks(): void {
    const { checks, range_deg, gap, of_builds } = this.explored!, tolerance = this.about.tolerance_mm;
    const asked = checks.filter((check) => check.asked), failed = asked.filter((check) => !check.holds).length;
    const unmet = checks.filter((check) => !check.asked && !check.holds).map((check) => check.name);
    const of = tolerance === null ? "" : of_builds ? TEXTS.ofBuilds(tolerance) : TEXTS.asDrawn(tolerance);
    part("state").textContent = gap
      ? TEXTS.gap(gap)
      : `${TEXTS.range(range_deg)}, ${TEXTS.failing(failed, asked.length)}${of}${TEXTS.notAsked(unmet)}`;
    part("state").classList.toggle("error", failed > 0 || gap !== "");
    part("check-count").textContent = TEXTS.failing(failed, asked.length);
    part("checks").replaceChildren(...checks.map((check) => this.checkLine(check)));
  }

  // One that is worst in a pose leads there.
  private checkLine(check: CheckMessage): HTMLElement {
    const line = document.createElement("li"), detail = document.createElement("small"), at = check.worst?.knee_deg;
    const shown = at === undefined ? line : button("", () => this.seekAngle(at));
    // Where nothing is asked, it is the value that is of a pose, not what is missing.
    const words = (parts: string[]) => parts.filter((text) => text !== "").join(" ");
    shown.textContent = check.asked ? TEXTS.check(check) : words([TEXTS.check(check), TEXTS.worst(check)]);
    detail.textContent = check.asked ? words([TEXTS.slack(check), TEXTS.worst(check)]) : TEXTS.slack(check);
    shown.append(detail);
    shown.classList.toggle("fails", !check.holds);
    shown.classList.toggle("unasked", !check.asked);
    line.dataset.asked = String(check.asked);
    line.dataset.check = check.name;
    line.dataset.holds = String(check.holds);
    if (shown !== line) line.append(shown);
    return line;
  }

  private seekAngle(degrees: number): void {
    const knee = this.explored?.curves?.now.knee;
    if (knee) this.seek(nearestRow(knee, degrees));
  }

  private seek(row: number, exact: DesignPage["exact"] = null): void {
    const curves = this.explored?.curves;
    let last = ROWS - 1;
    while (curves && last > 0 && curves.poses[last] === null) --last;
    this.row = Math.min(Math.max(row, 0), last);
    const scrub = part<HTMLInputElement>("stroke");
    scrub.max = String(last);
    scrub.value = String(this.row);
    this.exact = exact;
    this.view.show(curves ? (exact?.pose ?? curves.poses[this.row]) : null);
    for (const chart of Object.values(this.charts)) chart.showRow(this.row);
    const { knee, arm, force } = curves?.now ?? { knee: [], arm: [], force: [] };
    part("pose").textContent = curves ? TEXTS.pose(curves.stroke[this.row], knee[this.row], arm[this.row], force[this.row]) : "";
  }

  private fit(): void {
    const poses = this.explored?.curves?.poses.filter((pose) => pose !== null) ?? [];
    this.view.fit(poses as NonNullable<(typeof poses)[number]>[]);
  }

  private standingUpAndSittingDown(): () => void {
    let by = this.row > 0 ? -1 : 1;
    return () => {
      const before = this.row;
      this.seek(this.row + by);
      if (this.row === before) by = -by;
    };
  }

  // --- saving and optimising

  private showCommand(): void {
    server.optimiseCommand(this.links).then(({ command, why_not }) => {
      part("optimise-command").textContent = command ?? why_not ?? "";
      part("optimise").hidden = part("design-copy").hidden = command === undefined;
    }, sayWhy);
  }

  private save(): Promise<void> {
    return attempt(async () => say(TEXTS.savedAs((await server.save(this.links)).saved)));
  }

  private optimise(): Promise<void> {
    return attempt(async () => {
      const number = (await server.state()).optimum?.number ?? 0;
      const state = await server.optimise(this.links);
      this.startedOptimum = number;
      this.update(state);
    });
  }

  // --- keys and buttons

  private connect(): void {
    const scrub = part<HTMLInputElement>("stroke");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    onClick("design-zoom-in", () => this.view.zoomBy(1.5));
    onClick("design-zoom-out", () => this.view.zoomBy(1 / 1.5));
    onClick("design-zoom-fit", () => this.fit());
    onClick("design-undo", () => this.step(this.past, this.future, TEXTS.done.undo));
    onClick("design-redo", () => this.step(this.future, this.past, TEXTS.done.redo));
    onClick("design-reset", () => this.change(this.about.links));
    onClick("design-save", () => void this.save());
    onClick("optimise", () => void this.optimise());
    onClick("design-stop", () => void server.stop().catch(sayWhy));
    onClick("design-copy", () => void copyText("optimise-command"));
    onKey((event) => this.actionOf(event));
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.explored && this.take(this.explored));
  }

  private actionOf(event: KeyboardEvent): (() => void) | null {
    const undo = undoOf(event); // also in a number's field, where it is the design that goes back
    if (undo > 0) return () => this.step(this.past, this.future, TEXTS.done.undo);
    if (undo < 0) return () => this.step(this.future, this.past, TEXTS.done.redo);
    if (event.ctrlKey || event.metaKey || isOfControl(event)) return null;
    if (event.key === " ") return () => this.player.toggle();
    const keys: { [key: string]: () => void } = {
      ArrowLeft: () => this.seek(this.row - (event.shiftKey ? 10 : 1)),
      ArrowRight: () => this.seek(this.row + (event.shiftKey ? 10 : 1)),
      "+": () => this.view.zoomBy(1.5),
      "-": () => this.view.zoomBy(1 / 1.5),
      "0": () => this.fit(),
    };
    return keys[event.key] ?? null;
  }
}

function nearestRow(values: (number | null)[], wanted: number): number {
  let nearest = 0, least = Infinity;
  values.forEach((value, row) => {
    const away = value === null ? Infinity : Math.abs(value - wanted);
    if (away < least) {
      nearest = row;
      least = away;
    }
  });
  return nearest;
}

/** Links that the address ends with. */
function linksOfAddress(): number[] | null {
  const links = window.location.hash.slice(1).split(",").map(Number);
  return links.length === 6 && links.every((length) => length > 0 && Number.isFinite(length)) ? links : null;
}
