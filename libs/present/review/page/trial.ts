// A tracked trial: look at it, go from problem to problem, put right what is wrong.
import { Chart, Mark, Tick, Timeline, colourOf } from "./charts";
import {
  attempt, button, copy, copyText, isOfControl, item, onClick, onKey, part, save, say, sayWhy, showJob, undoOf,
} from "./dom";
import { Frames } from "./frames";
import { Measures } from "./measures";
import { Column, EditMessage, EventMessage, MarkerMessage, ProblemMessage, StateMessage, TrialMessage } from "./messages";
import { server } from "./server";
import { EVENTS_OF_WALKING, TEXTS } from "./texts";
import { PictureView, Point, distance, strokeCircle } from "./view";

const TRAIL = 25; // rows before and after
const SKELETON = ["ankle", "knee", "hip", "waist"];
const REACH = 14; // screen px in which a marker is taken hold of
const SNAP = 20; // screen px in which the detector looks for a marker

// What moves is seen, wherever in the picture it is.
function fromMedian(values: Column): Column {
  const known = values.filter((value): value is number => value !== null).sort((a, b) => a - b);
  return values.map((value) => (value === null ? null : value - known[known.length >> 1]));
}

const colourOfMarker = (index: number) => `--marker-${index % 7}`;
const colourOverPicture = (index: number) => `--over-${index % 7}`;

export class TrialPage {
  private rowOf = new Map<number, number>();
  private row = 0; // of the picture that is shown
  private wantedRow = 0;
  private selected = 0;
  private event = -1; // that was chosen
  private dragged: Point | null = null;
  private isPlacing = false;
  private isPlaying = false;
  private frames: Frames;
  private view: PictureView;
  private timeline: Timeline;
  private charts: { knee: Chart; lengths: Chart; residuals: Chart; places: Chart };
  private measures: Measures;
  private measuredFit = -1; // the revision that the measures are of
  private isReloading = false;
  private isApplying = false;

  constructor(private trial: TrialMessage) {
    part("trial").hidden = false;
    const last = trial.frame[trial.frame.length - 1];
    this.frames = new Frames(server.frame, last, (frame, picture) => this.shown(frame, picture), sayWhy);
    this.view = new PictureView(part("picture"), { x: trial.about.width, y: trial.about.height }, {
      draw: (context) => this.draw(context),
      grab: (at) => this.grab(at),
      drag: (at) => this.drag(at),
      drop: (at, free) => void this.place(at, free),
      click: (at, free) => this.click(at, free),
    });
    const rows = trial.frame.length, seek = (row: number) => this.seek(row);
    this.timeline = new Timeline(part("timeline"), trial.time_s, seek, (event) => this.chooseEvent(event),
      (event, row) => void this.moveEvent(event, row));
    this.charts = {
      knee: new Chart(part("knee-chart"), rows, seek),
      lengths: new Chart(part("lengths-chart"), rows, seek),
      residuals: new Chart(part("residuals-chart"), rows, seek),
      places: new Chart(part("places-chart"), rows, seek),
    };
    this.measures = new Measures(trial.markers.map((marker) => marker.name), trial.about.measures, rows, seek,
      () => this.showCommand());
    this.connect();
    this.take(trial);
    this.seek(0);
  }

  /** The server's state, asked for regularly; another window may have changed the trial. */
  update(state: StateMessage): void {
    this.showApplying(state);
    if (state.revision === this.trial.state.revision && state.fitted === this.trial.state.fitted) return;
    void this.reload();
  }

  private showApplying({ job }: StateMessage): void {
    const { running, failed } = job!, was = this.isApplying;
    this.isApplying = running;
    showJob("apply", job!, TEXTS.applying);
    if (running) {
      part<HTMLButtonElement>("apply").disabled = true;
    } else if (was) {
      say(failed ? TEXTS.notApplied(failed) : TEXTS.applied, failed !== "");
      this.measuredFit = -1;
      void this.reload();
    }
  }

  private async reload(): Promise<void> {
    if (this.isReloading) return;
    this.isReloading = true;
    await attempt(async () => this.take(await server.trial()));
    this.isReloading = false;
  }

  private take(trial: TrialMessage): void {
    this.trial = trial;
    this.rowOf = new Map(trial.frame.map((frame, row) => [frame, row]));
    document.title = `${trial.about.name} – lake review`;
    part("name").textContent = trial.about.name;
    this.showCommand();
    this.showState(trial.state);
    this.measure(trial.state);
    this.showProblems();
    this.showEvents();
    this.showCharts();
    this.showMarkers();
    this.showFrameText();
    this.view.redraw();
  }

  private showCommand(): void {
    const { command, command_with_events } = this.trial.about, isMoved = this.events().some((event) => event.moved);
    const words = TEXTS.measureWords(this.measures.added(), command.startsWith("lake track"));
    part("command").textContent = (isMoved ? command_with_events : command) + words;
  }

  private measure({ fitted, fit_error }: StateMessage): void {
    if (fitted === undefined || fitted < 0 || fitted === this.measuredFit || fit_error) return;
    this.measuredFit = fitted;
    void this.measures.ask();
  }

  private showState(state: StateMessage): void {
    const isFitting = state.fitted !== state.revision;
    part("state").textContent = isFitting ? TEXTS.fitting : TEXTS.saved(state.corrections ?? 0, state.swaps ?? 0);
    part("state").dataset.fitted = String(state.fitted);
    const why = !isFitting && state.fit_error ? [TEXTS.noFit(state.fit_error)] : [];
    part("warnings").replaceChildren(
      ...[...new Set([...why, ...this.trial.about.warnings, ...this.trial.warnings])].map(item));
    part("unapplied").textContent = state.is_applied ? "" : TEXTS.unapplied;
    part("apply").hidden = !this.trial.about.can_apply;
    part<HTMLButtonElement>("apply").disabled = state.is_applied! || this.isApplying;
    part<HTMLButtonElement>("undo").disabled = !state.can_undo;
    part<HTMLButtonElement>("redo").disabled = !state.can_redo;
  }

  // --- frames

  private seek(row: number): void {
    this.wantedRow = Math.min(Math.max(row, 0), this.trial.frame.length - 1);
    part<HTMLInputElement>("scrub").value = String(this.wantedRow);
    this.frames.want(this.trial.frame[this.wantedRow]);
  }

  // What is drawn over a picture is always that of the same frame.
  private shown(frame: number, picture: ImageBitmap): void {
    this.row = this.rowOf.get(frame) ?? this.row;
    this.dragged = null;
    this.view.show(picture);
    part("frame").dataset.frame = String(frame);
    this.showFrameText();
    this.timeline.showRow(this.row);
    for (const chart of Object.values(this.charts)) chart.showRow(this.row);
    this.measures.showRow(this.row);
    this.showMarkers();
  }

  private showFrameText(): void {
    const { frame, time_s, leg } = this.trial, row = this.row;
    const text = TEXTS.frame(frame[row], frame[frame.length - 1], time_s[row], leg?.knee[row] ?? null, leg?.knee_sigma[row] ?? null);
    part("frame").textContent = text;
    part<HTMLInputElement>("scrub").setAttribute("aria-valuetext", text);
  }

  private play(): void {
    this.isPlaying = !this.isPlaying;
    part("play").textContent = this.isPlaying ? TEXTS.pause : TEXTS.play;
    if (!this.isPlaying) return;
    const { time_s } = this.trial, end = time_s.length - 1;
    if (this.row === end) this.seek(0);
    let shown_s = time_s[this.wantedRow], last = performance.now();
    // It keeps to the time: frames whose pictures come too late are left out.
    const step = (now: number) => {
      if (!this.isPlaying) return;
      shown_s += (now - last) / 1000 * Number(part<HTMLSelectElement>("speed").value);
      last = now;
      if (this.wantedRow === this.row) {
        if (this.row === end) return this.play();
        let next = this.row;
        while (next < end && time_s[next + 1] <= shown_s) ++next;
        if (next !== this.row) this.seek(next);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  private goToFrame(text: string): void {
    const { frame } = this.trial, row = this.rowOf.get(Number(text));
    if (text === "" || row === undefined) return say(TEXTS.noFrame(text, frame[0], frame[frame.length - 1]));
    this.seek(row);
  }

  // --- problems

  private showProblems(): void {
    const { problems, markers } = this.trial;
    const lane = new Map(markers.map((marker, index) => [marker.name, index]));
    const marks: Mark[] = problems.map((problem) => ({
      first: this.rowAt(problem.first),
      last: this.rowAt(problem.last),
      colour: colourOf(`--${problem.kind}`),
      lane: lane.get(problem.marker) ?? 0,
    }));
    const ticks: Tick[] = this.events().map((event) => ({
      row: this.rowAt(event.frame),
      label: TEXTS.event(event.event, event.repetition),
      moved: event.moved,
    }));
    this.timeline.show(markers.map((marker) => marker.name), marks, ticks);
    part("problem-count").textContent = TEXTS.problems(problems.length);
    const MOST = 200;
    part("problems").replaceChildren(
      ...problems.slice(0, MOST).map((problem) => {
        const line = item("");
        line.append(button(this.problemText(problem), () => this.goTo(problem)));
        line.className = problem.kind;
        return line;
      }),
    );
  }

  private problemText(problem: ProblemMessage): string {
    return TEXTS.problem(problem.kind, problem.marker, problem.first, problem.last, problem.value);
  }

  private goTo(problem: ProblemMessage): void {
    this.seek(this.rowAt(problem.first));
    this.select(this.trial.markers.findIndex((marker) => marker.name === problem.marker));
    say(this.problemText(problem));
  }

  private nextProblem(step: 1 | -1): void {
    const here = this.trial.frame[this.wantedRow];
    const beyond = this.trial.problems.filter((problem) => (problem.first - here) * step > 0);
    const next = step > 0 ? beyond[0] : beyond[beyond.length - 1];
    if (next) this.goTo(next);
    else say(TEXTS.noProblem);
  }

  private rowAt(frame: number): number {
    return this.rowOf.get(frame) ?? 0;
  }

  // --- events

  private events(): EventMessage[] {
    return this.trial.leg?.events ?? [];
  }

  private eventName({ event, repetition }: EventMessage): string {
    return TEXTS.event(event, repetition);
  }

  private showEvents(): void {
    const events = this.events();
    if (this.event >= events.length) this.event = -1;
    part("event-count").textContent = TEXTS.events(events.length);
    const list = part("events");
    if (list.children.length !== events.length)
      list.replaceChildren(...events.map((_, index) => button("", () => this.goToEvent(index))));
    events.forEach((event, index) => {
      const shown = list.children[index] as HTMLElement;
      shown.textContent = TEXTS.eventAt(this.eventName(event), event.frame, event.moved);
      shown.setAttribute("aria-pressed", String(index === this.event));
      shown.dataset.event = `${event.event} ${event.repetition}`;
    });
    part<HTMLButtonElement>("event-here").disabled = this.event < 0;
    part("event-adding").hidden = !events.some(({ event }) => EVENTS_OF_WALKING.some(([name]) => name === event));
    part<HTMLButtonElement>("event-restore").disabled = !events[this.event]?.moved;
    this.timeline.select(this.event);
  }

  private chooseEvent(index: number): void {
    this.event = index;
    this.showEvents();
  }

  private goToEvent(index: number): void {
    const event = this.events()[index];
    if (!event) return;
    this.chooseEvent(index);
    this.seek(this.rowAt(event.frame));
    say(TEXTS.eventAt(this.eventName(event), event.frame, event.moved));
  }

  // From the chosen one round to the first; the first or the last where none is chosen.
  private nextEvent(step: 1 | -1): void {
    const count = this.events().length;
    if (count === 0) return say(TEXTS.events(0));
    this.goToEvent(this.event < 0 ? (step > 0 ? 0 : count - 1) : (this.event + step + count) % count);
  }

  private async moveEvent(index: number, row: number): Promise<void> {
    const chosen = this.events()[index];
    if (!chosen) return say(TEXTS.chooseEvent);
    const { repetition, event } = chosen, frame = this.trial.frame[row];
    if (await this.edit({ op: "move_event", repetition, event, frame })) say(TEXTS.eventMoved(this.eventName(chosen), frame));
    else this.timeline.redraw();
  }

  // Of the stride that the last heel strike before it begins; a heel strike begins the next one, whose number is free
  // where one was not found.
  private async addEvent(): Promise<void> {
    const event = part<HTMLSelectElement>("event-kind").value, frame = this.trial.frame[this.row];
    const strikes = this.events().filter((other) => other.event === "heel_strike" && other.frame < frame);
    const repetition = (strikes[strikes.length - 1]?.repetition ?? 0) + (event === "heel_strike" && strikes.length > 0 ? 1 : 0);
    const name = TEXTS.event(event, repetition);
    if (this.events().some((other) => other.event === event && other.repetition === repetition))
      return say(TEXTS.eventIsThere(name));
    if (await this.edit({ op: "move_event", repetition, event, frame })) say(TEXTS.eventMoved(name, frame));
  }

  private async restoreEvent(): Promise<void> {
    const chosen = this.events()[this.event];
    if (!chosen) return say(TEXTS.chooseEvent);
    const { repetition, event } = chosen;
    if (await this.edit({ op: "restore_event", repetition, event })) say(TEXTS.eventRestored(this.eventName(chosen)));
  }

  // --- markers

  private showMarkers(): void {
    const list = part("markers"), { markers } = this.trial;
    if (list.children.length !== markers.length)
      list.replaceChildren(...markers.map((marker, index) => this.markerButton(marker.name, index)));
    markers.forEach((marker, index) => this.showMarker(marker, index, list.children[index] as HTMLElement));
    const other = part<HTMLSelectElement>("swap-with"), before = other.value;
    const names = markers.map((marker) => marker.name).filter((_, index) => index !== this.selected);
    if (names.join() === [...other.options].map((option) => option.value).join()) return;
    other.replaceChildren(...names.map((name) => new Option(name, name)));
    if (names.includes(before)) other.value = before;
  }

  private markerButton(name: string, index: number): HTMLButtonElement {
    const made = button("", () => this.select(index));
    made.style.setProperty("--marker", `var(${colourOfMarker(index)})`);
    made.dataset.marker = name;
    const title = document.createElement("b");
    title.textContent = name;
    made.append(title, document.createElement("span"));
    return made;
  }

  private showMarker(marker: MarkerMessage, index: number, shown: HTMLElement): void {
    const at = this.placeOf(marker), isCorrected = marker.corrected.includes(this.row);
    const status = TEXTS.status[marker.status[this.row]];
    shown.setAttribute("aria-pressed", String(index === this.selected));
    shown.dataset.status = status;
    shown.dataset.corrected = String(isCorrected);
    const sigma = marker.sigma[this.row] ?? 0;
    shown.querySelector("span")!.textContent =
      (isCorrected ? TEXTS.corrected(at !== null, sigma) : status) + (at ? ` ${TEXTS.position(at.x, at.y, sigma)}` : "");
  }

  private select(index: number): void {
    if (index < 0 || index >= this.trial.markers.length) return;
    this.selected = index;
    this.showMarkers();
    this.showPlaces();
    this.proposeSwap();
    this.view.redraw();
  }

  // The marker beside the selected one: names are exchanged where markers meet.
  private proposeSwap(): void {
    const here = this.placeOf(this.marker());
    if (!here) return;
    const others = this.trial.markers.filter((marker) => marker !== this.marker() && this.placeOf(marker));
    const away = (marker: MarkerMessage) => distance(here, this.placeOf(marker)!);
    if (others.length === 0) return;
    part<HTMLSelectElement>("swap-with").value = others.reduce((a, b) => (away(b) < away(a) ? b : a)).name;
  }

  private marker(): MarkerMessage {
    return this.trial.markers[this.selected];
  }

  private placeOf(marker: MarkerMessage, row = this.row): Point | null {
    const x = marker.x[row], y = marker.y[row];
    return x === null || y === null || x === undefined || y === undefined ? null : { x, y };
  }

  private grab(at: Point): boolean {
    if (this.isPlacing) return false;
    const reach = REACH / this.view.scale();
    let nearest = -1, least = reach;
    this.trial.markers.forEach((marker, index) => {
      const there = this.placeOf(marker), away = there ? distance(there, at) : Infinity;
      if (away > least || (away === least && index !== this.selected)) return;
      nearest = index;
      least = away;
    });
    if (nearest < 0) return false;
    this.select(nearest);
    return true;
  }

  private drag(at: Point): void {
    this.dragged = at;
    this.view.redraw();
  }

  private click(at: Point, free: boolean): void {
    if (!this.isPlacing) return;
    this.endPlacing();
    void this.place(at, free);
  }

  private startPlacing(): void {
    this.isPlacing = true;
    part("picture").classList.add("placing");
    say(TEXTS.placing(this.marker().name));
  }

  private endPlacing(): void {
    this.isPlacing = false;
    part("picture").classList.remove("placing");
  }

  // --- changes

  private async edit(edit: EditMessage): Promise<boolean> {
    try {
      this.showState(await server.edit(edit));
      await this.reload();
      return true;
    } catch (why) {
      this.dragged = null;
      this.view.redraw();
      sayWhy(why);
      return false;
    }
  }

  private async undo(op: "undo" | "redo"): Promise<void> {
    if (await this.edit({ op })) say(TEXTS.done[op]);
  }

  private async place(at: Point, free: boolean): Promise<void> {
    const name = this.marker().name, frame = this.trial.frame[this.row];
    await attempt(async () => {
      const reach = Math.min(Math.max(SNAP / this.view.scale(), 2), 100);
      const snapped = free ? null : await server.snap({ frame, marker: name, x: at.x, y: at.y, reach });
      const done = await this.edit({ op: "place", frame, marker: name, ...(snapped ?? { x: at.x, y: at.y }) });
      if (done) say(snapped ? TEXTS.snapped(name, snapped.x, snapped.y) : TEXTS.placedFree(name));
    });
    this.dragged = null;
    this.view.redraw();
  }

  private here(): { frame: number; marker: string } {
    return { frame: this.trial.frame[this.row], marker: this.marker().name };
  }

  private async swap(): Promise<void> {
    const other = part<HTMLSelectElement>("swap-with").value, { frame, marker } = this.here();
    if (await this.edit({ op: "swap", frame, marker, other })) say(TEXTS.swapped(marker, other, frame));
  }

  // By keys: a screen px in each step, nothing snaps.
  private nudge(x: number, y: number): void {
    const at = this.placeOf(this.marker()) ?? this.view.middle(), step = 1 / this.view.scale();
    void this.place({ x: at.x + x * step, y: at.y + y * step }, true);
  }

  // --- drawing

  private draw(context: CanvasRenderingContext2D): void {
    this.drawSkeleton(context);
    this.trial.markers.forEach((marker, index) => this.drawMarker(context, marker, index));
  }

  private shownPlace(marker: MarkerMessage): Point | null {
    const isDragged = this.dragged && marker === this.marker();
    return isDragged ? this.dragged : this.placeOf(marker);
  }

  private drawSkeleton(context: CanvasRenderingContext2D): void {
    const joints = SKELETON.map((name) => this.trial.markers.find((marker) => marker.name === name));
    context.strokeStyle = "rgba(255, 255, 255, 0.7)";
    context.lineWidth = 1.5;
    this.view.strokeLine(context, joints.map((joint) => (joint ? this.shownPlace(joint) : null)));
  }

  private drawMarker(context: CanvasRenderingContext2D, marker: MarkerMessage, index: number): void {
    context.strokeStyle = context.fillStyle = colourOf(colourOverPicture(index));
    this.drawTrail(context, marker);
    const at = this.shownPlace(marker);
    if (!at) return;
    const { x, y } = this.view.toScreen(at), status = marker.status[this.row];
    const isSelected = index === this.selected, size = isSelected ? 12 : 9;
    context.lineWidth = isSelected ? 2.5 : 1.5;
    context.setLineDash(status === "f" ? [3, 3] : []);
    strokeCircle(context, { x, y }, size);
    // The place itself: two deviations, where they are large enough to be seen.
    strokeCircle(context, { x, y }, Math.max(2 * (marker.sigma[this.row] ?? 0) * this.view.scale(), 1));
    context.setLineDash([]);
    context.font = `${isSelected ? "bold " : ""}12px system-ui, sans-serif`;
    this.view.label(context, marker.name, { x: x + size + 3, y: y - size });
  }

  private drawTrail(context: CanvasRenderingContext2D, marker: MarkerMessage): void {
    context.globalAlpha = 0.7;
    context.lineWidth = 1;
    const from = Math.max(this.row - TRAIL, 0), to = Math.min(this.row + TRAIL, this.trial.frame.length - 1);
    const places: (Point | null)[] = [];
    for (let row = from; row <= to; ++row) places.push(this.placeOf(marker, row));
    this.view.strokeLine(context, places);
    context.globalAlpha = 1;
  }

  private showCharts(): void {
    const { leg, markers } = this.trial;
    part("knee-title").textContent = TEXTS.knee;
    part("lengths-title").textContent = TEXTS.lengths;
    part("residuals-title").textContent = TEXTS.residuals;
    this.charts.knee.show(leg ? [{ name: "", colour: "--accent", values: leg.knee, sigma: leg.knee_sigma }] : []);
    this.charts.lengths.show(
      [TEXTS.shank, TEXTS.thigh, TEXTS.trunk]
        .map((name, index) => ({ name, colour: colourOfMarker(index), values: this.lengths(index) }))
        .filter((curve) => curve.values.some((value) => value !== null)),
    );
    this.charts.residuals.show(
      markers.map((marker, index) => ({ name: marker.name, colour: colourOfMarker(index), values: marker.residual })),
    );
    this.showPlaces();
  }

  private showPlaces(): void {
    const { name, x, y } = this.marker();
    part("places-title").textContent = TEXTS.places(name);
    this.charts.places.show([
      { name: "x", colour: colourOfMarker(0), values: fromMedian(x) },
      { name: "y", colour: colourOfMarker(1), values: fromMedian(y) },
    ]);
  }

  // Beside the title of a chart: its curves, with frames and times, to the clipboard or into a file.
  private addCurveButtons(chart: keyof TrialPage["charts"]): void {
    const csv = () => this.charts[chart].csv({ frame: this.trial.frame, time_s: this.trial.time_s }, chart);
    const name = () => `${this.trial.about.name.replace(/\.[^.]*$/, "")}-${chart}.csv`;
    const title = part(`${chart}-title`), bar = document.createElement("div");
    bar.className = "bar";
    title.replaceWith(bar);
    bar.append(title, button(TEXTS.copyCurves, () => void copy(csv())), button(TEXTS.saveCurves, () => save(csv(), name())));
  }

  // Of the skeleton's segment, also where no leg can be fitted: exchanged names show here.
  private lengths(segment: number): Column {
    const [lower, upper] = [segment, segment + 1].map((joint) =>
      this.trial.markers.find((marker) => marker.name === SKELETON[joint]),
    );
    if (!lower || !upper) return [];
    const lengths = this.trial.frame.map((_, row) => {
      const a = this.placeOf(lower, row), b = this.placeOf(upper, row);
      return a && b ? distance(a, b) : null;
    });
    const known = lengths.filter((length): length is number => length !== null).sort((a, b) => a - b);
    const median = known[known.length >> 1];
    return lengths.map((length) => (length === null ? null : 100 * (length / median - 1)));
  }

  // --- keys and buttons

  private connect(): void {
    const scrub = part<HTMLInputElement>("scrub");
    scrub.max = String(this.trial.frame.length - 1);
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
    part("play").textContent = TEXTS.play;
    onClick("play", () => this.play());
    const SPEEDS = [1, 0.5, 0.25, 0.1];
    part("speed").replaceChildren(...SPEEDS.map((factor) => new Option(TEXTS.speed(factor), String(factor))));
    const goTo = part<HTMLInputElement>("go-to");
    goTo.max = String(this.trial.frame[this.trial.frame.length - 1]);
    goTo.addEventListener("change", () => this.goToFrame(goTo.value));
    onClick("back", () => this.seek(this.wantedRow - 1));
    onClick("on", () => this.seek(this.wantedRow + 1));
    onClick("problem-back", () => this.nextProblem(-1));
    onClick("problem-on", () => this.nextProblem(1));
    onClick("zoom-in", () => this.zoomToMarker());
    onClick("zoom-out", () => this.view.zoomBy(0.5));
    onClick("zoom-fit", () => this.view.fit());
    onClick("add", () => this.startPlacing());
    onClick("hide", () => void this.edit({ op: "hide", ...this.here() }));
    onClick("restore", () => void this.edit({ op: "restore", ...this.here() }));
    onClick("swap", () => void this.swap());
    onClick("apply", () => void attempt(async () => this.update(await server.apply())));
    onClick("apply-stop", () => void server.stop().catch(sayWhy));
    onClick("trial-copy", () => void copyText("command"));
    for (const chart of ["knee", "lengths", "residuals", "places"] as const) this.addCurveButtons(chart);
    onClick("event-here", () => void this.moveEvent(this.event, this.row));
    onClick("event-restore", () => void this.restoreEvent());
    onClick("event-add", () => void this.addEvent());
    part("event-kind").replaceChildren(...EVENTS_OF_WALKING.map(([event, name]) => new Option(name, event)));
    onClick("undo", () => void this.undo("undo"));
    onClick("redo", () => void this.undo("redo"));
    onKey((event) => this.actionOf(event));
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.take(this.trial));
  }

  private zoomToMarker(): void {
    const at = this.placeOf(this.marker());
    if (at) this.view.focus(at, 2);
    this.view.zoomBy(2);
  }

  private actionOf(event: KeyboardEvent): (() => void) | null {
    const undo = undoOf(event);
    if (undo !== 0) return () => void this.undo(undo > 0 ? "undo" : "redo");
    if (event.ctrlKey || event.metaKey || isOfControl(event)) return null;
    const arrows: { [key: string]: [number, number] } = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    };
    const arrow = arrows[event.key];
    if (arrow && event.altKey) return () => this.nudge(...arrow);
    if (arrow && arrow[0] !== 0) return () => this.seek(this.wantedRow + arrow[0] * (event.shiftKey ? 10 : 1));
    if (event.key === " ") return () => this.play();
    const number = Number(event.key);
    if (number >= 1 && number <= this.trial.markers.length) return () => this.select(number - 1);
    const keys: { [key: string]: () => void } = {
      "[": () => this.nextProblem(-1),
      "]": () => this.nextProblem(1),
      "+": () => this.zoomToMarker(),
      "-": () => this.view.zoomBy(0.5),
      "0": () => this.view.fit(),
      g: () => part("go-to").focus(),
      a: () => this.startPlacing(),
      h: () => void this.edit({ op: "hide", ...this.here() }),
      r: () => void this.edit({ op: "restore", ...this.here() }),
      x: () => void this.swap(),
      e: () => this.nextEvent(1),
      E: () => this.nextEvent(-1),
      m: () => void this.moveEvent(this.event, this.row),
      Escape: () => this.endPlacing(),
      Enter: () => void this.place(this.placeOf(this.marker()) ?? this.view.middle(), false),
    };
    return keys[event.key] ?? null;
  }
}
