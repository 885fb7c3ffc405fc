// Two trials side by side, each at the same percent of its rise, with their misalignment in step.
import { Chart, colourOf } from "./charts";
import { isTyping, part, sayWhy } from "./dom";
import { Frames } from "./frames";
import { Column, ComparedVideoMessage, ComparisonMessage } from "./messages";
import { Player } from "./player";
import { server } from "./server";
import { TEXTS } from "./texts";
import { PictureView, Point } from "./view";

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
    rise.replaceChildren(...this.rises.map((one) => new Option(TEXTS.rise(one), String(one))));
    rise.addEventListener("change", changed);
    this.view = new PictureView(part(`${role}-picture`), { x: trial.width, y: trial.height }, {
      draw: (context) => this.draw(context),
      grab: () => false,
      drag: () => undefined,
      drop: () => undefined,
      click: () => undefined,
    });
    this.frames = new Frames(server.frameOf(role), trial.frame[trial.frame.length - 1], (frame, picture) => {
      this.shownRow = trial.frame.indexOf(frame);
      part(`${role}-picture`).dataset.frame = String(frame);
      this.view.show(picture);
    }, sayWhy);
    this.choose = (percent) => {
      const row = nearest(trial, Number(rise.value), percent);
      if (row !== null) this.frames.want(trial.frame[row]);
    };
  }

  choose: (percent: number) => void;

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
      context.beginPath();
      context.arc(at.x, at.y, isCompared ? 10 : 6, 0, 2 * Math.PI);
      context.stroke();
      context.font = `${isCompared ? "bold " : ""}12px system-ui, sans-serif`;
      context.fillText(name, at.x + 12, at.y - 8);
    });
    context.globalAlpha = 1;
  }
}

export class ComparisonPage {
  private percent = 0;
  private player: Player;
  private views: ComparedView[];
  private charts: Chart[];

  constructor(private message: ComparisonMessage) {
    const { curves } = message;
    part("comparison").hidden = false;
    part("name").textContent = message.name;
    document.title = `${message.name} – lake review`;
    const { placement, timing, shape } = curves.parts;
    part("state").textContent = TEXTS.comparisonState(curves.rms_mm, placement, timing, shape);
    const seek = (percent: number) => this.seek(percent);
    this.views = ROLES.map((role) => new ComparedView(role, message[role], () => this.seek(this.percent)));
    const chart = (id: string, title: string, shown: { name: string; colour: string; values: Column }[]) => {
      part(`${id}-title`).textContent = title;
      const made = new Chart(part(`${id}-chart`), curves.percent.length, seek);
      made.show(shown);
      return made;
    };
    this.charts = [
      chart("misalignment", TEXTS.misalignment, [{ name: "", colour: "--accent", values: curves.distance_mm }]),
      chart("knees", TEXTS.knees, [
        { name: TEXTS.human, colour: "--marker-1", values: curves.human_knee_deg },
        { name: TEXTS.exo, colour: "--marker-4", values: curves.exo_knee_deg },
      ]),
    ];
    if (!this.views.every((view) => view.hasRise())) sayWhy(TEXTS.noRise);
    const scrub = part<HTMLInputElement>("percent-scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    this.player = new Player("comparison-play", PLAY_MS, () => () => this.seek(this.percent === 100 ? 0 : this.percent + 1));
    document.addEventListener("keydown", (event) => this.key(event));
    this.seek(0);
  }

  private seek(percent: number): void {
    const { curves } = this.message;
    this.percent = Math.min(Math.max(percent, 0), curves.percent.length - 1);
    part<HTMLInputElement>("percent-scrub").value = String(this.percent);
    for (const view of this.views) view.choose(this.percent);
    for (const chart of this.charts) chart.showRow(this.percent);
    part("percent").textContent = TEXTS.ofRise(
      this.percent, curves.distance_mm[this.percent], curves.human_knee_deg[this.percent], curves.exo_knee_deg[this.percent]);
  }

  private key(event: KeyboardEvent): void {
    const isSlider = event.target instanceof HTMLInputElement;
    if (isTyping(event) || event.ctrlKey || event.metaKey) return;
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === " " && !(event.target instanceof HTMLButtonElement)) this.player.toggle();
    else if (by && !isSlider) this.seek(this.percent + by * (event.shiftKey ? 10 : 1));
    else return;
    event.preventDefault();
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
