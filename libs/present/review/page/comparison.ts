// Two trials side by side, each at the same percent of its rise, with their misalignment in step.
import { Chart, colourOf } from "./charts";
import { isOfControl, onKey, part, sayWhy } from "./dom";
import { Frames } from "./frames";
import { Column, ComparedVideoMessage, ComparisonMessage, RiseMessage } from "./messages";
import { Player } from "./player";
import { server } from "./server";
import { TEXTS } from "./texts";
import { PictureView, Point, strokeCircle } from "./view";

type Role = "human" | "exo";
const ROLES: Role[] = ["human", "exo"];
const PLAY_MS = 40;
const TRAIL = 15; // rows before what is shown

class ComparedView {
  private view: PictureView;
  private frames: Frames;
  private rises: number[];
  private shownRow = 0;

  constructor(role: Role, private trial: ComparedVideoMessage, changed: () => void) {
    part(`${role}-name`).textContent = TEXTS.compared(TEXTS.role[role], trial.name, trial.marker);
    this.rises = [...new Set(trial.repetition.filter((one): one is number => one !== null))];
    const rise = part<HTMLSelectElement>(`${role}-rise`);
    const mean = trial.rises.length > 1 ? [new Option(TEXTS.meanRise, "")] : [];
    rise.replaceChildren(...mean, ...this.rises.map((one) => new Option(TEXTS.rise(one), String(one))));
    this.chosen = () => (rise.value === "" ? null : Number(rise.value));
    rise.addEventListener("change", changed);
    this.view = new PictureView(part(`${role}-picture`), { x: trial.width, y: trial.height }, {
      draw: (context) => this.draw(context),
    });
    this.frames = new Frames(server.frameOf(role), trial.frame[trial.frame.length - 1], (frame, picture) => {
      this.shownRow = trial.frame.indexOf(frame);
      part(`${role}-picture`).dataset.frame = String(frame);
      this.view.show(picture);
    }, sayWhy);
    this.choose = (percent) => {
      const row = nearest(trial, this.chosen() ?? this.rises[0], percent); // of the mean the first is shown
      if (row !== null) this.frames.want(trial.frame[row]);
    };
  }

  choose: (percent: number) => void;
  /** The number of the rise that was chosen; null: the mean of all. */
  chosen: () => number | null;

  /** Its curves, or the mean of all; null where this rise does not count in the comparison. */
  curve(): RiseMessage | null {
    const chosen = this.chosen(), { rises } = this.trial;
    if (chosen !== null) return rises.find(({ repetition }) => repetition === chosen) ?? null;
    const mean = (pick: (rise: RiseMessage) => number[]) =>
      pick(rises[0]).map((_, percent) => rises.reduce((sum, rise) => sum + pick(rise)[percent], 0) / rises.length);
    return { repetition: 0, x: mean(({ x }) => x), y: mean(({ y }) => y), knee_deg: mean(({ knee_deg }) => knee_deg) };
  }

  hasRise(): boolean {
    return this.rises.length > 0;
  }

  private draw(context: CanvasRenderingContext2D): void {
    this.trial.markers.forEach(({ name, x, y }, index) => {
      const isCompared = name === this.trial.marker;
      context.strokeStyle = context.fillStyle = colourOf(`--over-${index % 7}`);
      context.lineWidth = isCompared ? 2.5 : 1.2;
      context.globalAlpha = isCompared ? 1 : 0.7;
      const trail: (Point | null)[] = [];
      for (let row = Math.max(this.shownRow - TRAIL, 0); row <= this.shownRow; ++row) trail.push(pointOf(x[row], y[row]));
      this.view.strokeLine(context, trail);
      const here = pointOf(x[this.shownRow], y[this.shownRow]);
      if (!here) return;
      const at = this.view.toScreen(here);
      strokeCircle(context, at, isCompared ? 10 : 6);
      context.font = `${isCompared ? "bold " : ""}12px system-ui, sans-serif`;
      this.view.label(context, name, { x: at.x + 12, y: at.y - 8 });
    });
    context.globalAlpha = 1;
  }
}

export class ComparisonPage {
  private percent = 0;
  private player: Player;
  private views: ComparedView[];
  private charts: { misalignment: Chart; knees: Chart };
  private shown: { distance_mm: Column; human_knee_deg: Column; exo_knee_deg: Column };

  constructor(private message: ComparisonMessage) {
    const { curves } = message;
    part("comparison").hidden = false;
    part("name").textContent = message.name;
    document.title = `${message.name} – lake review`;
    const seek = (percent: number) => this.seek(percent);
    this.shown = curves;
    this.views = ROLES.map((role) => new ComparedView(role, message[role], () => this.showRises()));
    const chart = (id: string, title: string) => {
      part(`${id}-title`).textContent = title;
      return new Chart(part(`${id}-chart`), curves.percent.length, seek);
    };
    this.charts = { misalignment: chart("misalignment", TEXTS.misalignment), knees: chart("knees", TEXTS.knees) };
    if (!this.views.every((view) => view.hasRise())) sayWhy(TEXTS.noRise);
    const scrub = part<HTMLInputElement>("percent-scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    this.player = new Player("comparison-play", PLAY_MS, () => () => this.seek(this.percent === 100 ? 0 : this.percent + 1));
    onKey((event) => this.actionOf(event));
    this.showRises();
  }

  // The numbers are of the rises that are chosen; of both means they are the comparison's own.
  private showRises(): void {
    const [human, exo] = this.views.map((view) => view.curve()), { curves } = this.message;
    const [humanRise, exoRise] = this.views.map((view) => view.chosen());
    const areMeans = humanRise === null && exoRise === null;
    const isOnly = this.message.human.rises.length === 1 && this.message.exo.rises.length === 1;
    if (areMeans || isOnly) {
      this.shown = curves;
      part("state").textContent = TEXTS.comparisonState(curves.rms_mm, curves.parts);
    } else if (human && exo) {
      const distance_mm = human.x.map((x, percent) => Math.hypot(exo.x[percent] - x, exo.y[percent] - human.y[percent]));
      this.shown = { distance_mm, human_knee_deg: human.knee_deg, exo_knee_deg: exo.knee_deg };
      const rms = Math.sqrt(distance_mm.reduce((sum, mm) => sum + mm * mm, 0) / distance_mm.length);
      part("state").textContent = TEXTS.ofRises(rms, human.repetition, exo.repetition);
    } else {
      const none = curves.percent.map(() => null);
      this.shown = { distance_mm: none, human_knee_deg: none, exo_knee_deg: none };
      part("state").textContent = TEXTS.riseLeftOut;
    }
    this.charts.misalignment.show([{ name: "", colour: "--accent", values: this.shown.distance_mm }]);
    this.charts.knees.show([
      { name: TEXTS.human, colour: "--marker-1", values: this.shown.human_knee_deg },
      { name: TEXTS.exo, colour: "--marker-4", values: this.shown.exo_knee_deg },
    ]);
    this.seek(this.percent);
  }

  private seek(percent: number): void {
    const { curves } = this.message;
    this.percent = Math.min(Math.max(percent, 0), curves.percent.length - 1);
    part<HTMLInputElement>("percent-scrub").value = String(this.percent);
    for (const view of this.views) view.choose(this.percent);
    for (const chart of Object.values(this.charts)) chart.showRow(this.percent);
    const { distance_mm, human_knee_deg, exo_knee_deg } = this.shown, at = this.percent;
    part("percent").textContent = TEXTS.ofRise(at, distance_mm[at], human_knee_deg[at], exo_knee_deg[at]);
  }

  private actionOf(event: KeyboardEvent): (() => void) | null {
    if (isOfControl(event) || event.ctrlKey || event.metaKey) return null;
    if (event.key === " ") return () => this.player.toggle();
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    return by ? () => this.seek(this.percent + by * (event.shiftKey ? 10 : 1)) : null;
  }
}

const pointOf = (x: number | null, y: number | null): Point | null => (x === null || y === null ? null : { x, y });

/** The row of this rise whose percent is nearest. */
function nearest(trial: ComparedVideoMessage, repetition: number, percent: number): number | null {
  let found: number | null = null, least = Infinity;
  trial.percent.forEach((at, row) => {
    if (at === null || trial.repetition[row] !== repetition || Math.abs(at - percent) >= least) return;
    found = row;
    least = Math.abs(at - percent);
  });
  return found;
}
