// An exoskeleton aligned while it is worn: what the camera sees, what to do, in large letters, curves, rises.
import { Chart, colourOf } from "./charts";
import { attempt, button, isOfControl, item, onClick, onKey, part, say, showProgress } from "./dom";
import { Column, LiveAct, LiveMessage, LiveStateMessage, LiveViewMessage } from "./messages";
import { server } from "./server";
import { TEXTS, unbroken } from "./texts";
import { PictureView, Point, distance, strokeCircle } from "./view";

const SHOWN_S = 20, STEP_S = 0.05; // of the curves
const CURVES_MS = 100; // between two drawings of them: they move by a few pixels
const LATE_S = 1; // what a person would wonder at
const TRAIL = 20; // frames
const ARROW_PX = 6, LEAST_ARROW_PX = 80;

type Sample = LiveViewMessage["samples"][number];

export class LivePage {
  private view: PictureView;
  private shown: LiveViewMessage | null = null;
  private picture: ImageBitmap | null = null; // that is shown
  private curvesDrawn_ms = 0;
  private samples: Sample[] = [];
  private trails = new Map<string, Point[]>();
  private placing: string | null = null; // the name that the next click gives
  private phase: LiveStateMessage["phase"] = "watching";
  private names = new Map<string, HTMLButtonElement>();
  private charts: { knee: Chart; joint: Chart };
  private chime = new Chime();
  private chimed = ""; // what was said last

  constructor(private message: LiveMessage) {
    part("live").hidden = false;
    part("name").textContent = message.input;
    document.title = `${message.input} – lake live`;
    part("live-folder").textContent = message.folder;
    this.view = new PictureView(part("live-picture"), { x: message.width, y: message.height }, {
      draw: (context) => this.draw(context),
      click: (at) => this.click(at),
    });
    const chart = (id: string, title: string) => {
      part(`live-${id}-title`).textContent = title;
      const made = new Chart(part(`live-${id}-chart`), SHOWN_S / STEP_S + 1, () => undefined);
      made.showRow(SHOWN_S / STEP_S); // now
      return made;
    };
    this.charts = { knee: chart("knee", TEXTS.liveKnee), joint: chart("joint", TEXTS.liveJoint) };
    for (const [index, name] of message.markers.entries()) {
      const made = button(name, () => this.place(name));
      made.style.setProperty("--marker", `var(--marker-${index % 7})`);
      this.names.set(name, made);
      part("live-names").append(made);
    }
    onClick("live-trial", () => this.beginOrEnd());
    onClick("live-moved", () => this.moved());
    const sound = part<HTMLInputElement>("live-sound");
    sound.addEventListener("change", () => this.chime.turn(sound.checked));
    onKey((event) => this.actionOf(event));
    void this.follow();
  }

  // Frame after frame, as quickly as they can be shown; none is drawn over but by its own markers.
  private async follow(): Promise<void> {
    let after = -1;
    while (this.phase === "watching" || this.phase === "trial") {
      try {
        const next = await server.liveView(after);
        if (next.frame === after) continue;
        const picture = await server.livePicture(next.frame);
        const isNew = after >= 0; // what a page finds when it is opened may be old
        after = next.frame;
        this.take(next);
        this.view.show(picture);
        this.picture?.close(); // megabytes, that else wait for the browser to clear up
        this.picture = picture;
        Object.assign(part("live-picture").dataset, { frame: next.frame, arrived: next.arrived_ms });
        const late_s = (Date.now() - next.arrived_ms) / 1000;
        part("live-late").textContent = isNew && late_s > LATE_S ? TEXTS.late(late_s) : "";
      } catch {
        await new Promise((resolve) => setTimeout(resolve, 300)); // a picture that is gone already; the next one comes
      }
    }
  }

  private take(next: LiveViewMessage): void {
    this.shown = next;
    this.samples.push(...next.samples);
    this.samples = this.samples.filter(([time_s]) => time_s > next.time_s - SHOWN_S);
    for (const { name, x, y } of next.markers) {
      const trail = this.trails.get(name) ?? [];
      if (x !== null && y !== null) trail.push({ x, y });
      this.trails.set(name, trail.slice(-TRAIL));
    }
    const now_ms = performance.now();
    if (now_ms - this.curvesDrawn_ms < CURVES_MS) return;
    this.curvesDrawn_ms = now_ms;
    this.drawCurves(next.time_s);
  }

  private drawCurves(until_s: number): void {
    const column = (index: 1 | 2 | 3): Column => {
      const values: Column = new Array(SHOWN_S / STEP_S + 1).fill(null);
      for (const sample of this.samples) values[Math.round((sample[0] - until_s + SHOWN_S) / STEP_S)] = sample[index];
      return values;
    };
    this.charts.knee.show([{ name: "", colour: "--accent", values: column(1) }]);
    this.charts.joint.show([
      { name: TEXTS.anterior, colour: "--marker-4", values: column(2) },
      { name: TEXTS.above, colour: "--marker-2", values: column(3) },
    ]);
  }

  private draw(context: CanvasRenderingContext2D): void {
    if (!this.shown) return;
    context.font = "bold 14px system-ui, sans-serif";
    for (const spot of this.shown.spots) {
      if (spot.name !== "") continue;
      const at = this.view.toScreen(spot);
      context.strokeStyle = colourOf("--over-5");
      context.setLineDash([4, 4]);
      context.lineWidth = 1.5;
      strokeCircle(context, at, Math.max(spot.radius * this.view.scale(), 4) + 5);
    }
    context.setLineDash([]);
    this.shown.markers.forEach(({ name, x, y }, index) => {
      if (x === null || y === null) return;
      const at = this.view.toScreen({ x, y });
      context.strokeStyle = context.fillStyle = colourOf(`--over-${index % 7}`);
      context.lineWidth = 1.5;
      this.view.strokeLine(context, this.trails.get(name) ?? []);
      context.lineWidth = 2.5;
      strokeCircle(context, at, 9);
      this.view.label(context, name, { x: at.x + 13, y: at.y + 5 });
    });
    this.drawArrow(context);
  }

  private drawArrow(context: CanvasRenderingContext2D): void {
    if (!this.shown?.move) return;
    const [from, to] = this.shown.move.map(([x, y]) => this.view.toScreen({ x, y }));
    const length = distance(from, to);
    if (length < 2) return;
    this.drawPointer(context, to, { x: (to.x - from.x) / length, y: (to.y - from.y) / length }, Math.max(length, LEAST_ARROW_PX));
  }

  // It ends where the move ends; as an arrow of some millimetres cannot be seen, it may begin behind the joint.
  private drawPointer(context: CanvasRenderingContext2D, to: Point, along: Point, length: number): void {
    const from = { x: to.x - length * along.x, y: to.y - length * along.y };
    const head = 3 * ARROW_PX;
    const corner = (side: number) => ({
      x: to.x - head * along.x - side * 0.6 * head * along.y,
      y: to.y - head * along.y + side * 0.6 * head * along.x,
    });
    context.lineCap = "round";
    for (const [colour, width] of [["#000", ARROW_PX + 3], ["#fff", ARROW_PX]] as const) {
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(from.x, from.y);
      context.lineTo(to.x - head * along.x, to.y - head * along.y);
      context.stroke();
      context.lineWidth = width - ARROW_PX + 1;
      context.beginPath();
      context.moveTo(to.x, to.y);
      for (const side of [1, -1]) context.lineTo(corner(side).x, corner(side).y);
      context.closePath();
      context.fill();
      context.stroke();
    }
  }

  private act(act: LiveAct, said: (state: LiveStateMessage) => string): Promise<void> {
    return attempt(async () => {
      const state = await server.act(act);
      this.update(state);
      say(said(state));
    });
  }

  private beginOrEnd(): void {
    const what = this.phase === "watching" ? "begin" : "end";
    void this.act({ what }, () => "");
  }

  private moved(): void {
    void this.act({ what: "moved" }, ({ moves }) => TEXTS.movedSaid(moves));
  }

  private place(name: string | null): void {
    this.placing = name;
    part("live-picture").classList.toggle("placing", name !== null);
    for (const [other, made] of this.names) made.setAttribute("aria-pressed", String(other === name));
    say(name === null ? "" : TEXTS.clickSpot(name));
  }

  private click(at: Point): void {
    const name = this.placing;
    if (name === null) return;
    this.place(null);
    void this.act({ what: "name", name, x: at.x, y: at.y }, () => TEXTS.named(name));
  }

  private actionOf(event: KeyboardEvent): (() => void) | null {
    if (isOfControl(event) || event.ctrlKey || event.metaKey || event.repeat) return null;
    const isOn = this.phase === "watching" || this.phase === "trial";
    if (event.key === "Escape") return () => this.place(null);
    if (event.key === " " && isOn) return () => this.beginOrEnd();
    return event.key.toLowerCase() === "m" && isOn ? () => this.moved() : null;
  }

  update(state: LiveStateMessage): void {
    this.phase = state.phase;
    const isOn = state.phase === "watching" || state.phase === "trial";
    part("state").textContent = TEXTS.phase(state);
    if (!isOn) part("live-late").textContent = "";
    if (state.failed !== "") say(state.failed, true);
    const trial = part<HTMLButtonElement>("live-trial");
    trial.textContent = state.phase === "watching" ? TEXTS.beginTrial : TEXTS.endTrial;
    trial.disabled = part<HTMLButtonElement>("live-moved").disabled = !isOn;
    const progress = part<HTMLProgressElement>("live-progress");
    progress.hidden = state.phase !== "finishing";
    showProgress(progress, state.progress);
    this.showPlace(state);
    this.tellBySound(state);
    part("live-naming").textContent = state.is_named ? "" : TEXTS.notNamed(state.missing);
    part("live-naming").title = state.why_not_named;
    for (const [name, made] of this.names) made.classList.toggle("missing", state.missing.includes(name));
    part("live-rise-count").textContent = TEXTS.riseCount(state.rises.length);
    part("live-rises").replaceChildren(...state.rises.map(({ offset_mm: [x, y], moves }, index) =>
      item(unbroken(TEXTS.riseRow(index + 1, x, y, moves)))));
    const bad = state.checks.filter(({ verdict }) => verdict === "poor" || verdict === "unfit").length;
    part("live-check-count").textContent = TEXTS.checkCount(bad);
    part("live-checks").replaceChildren(...state.checks.map(({ shown, verdict, advice }) => {
      const line = item(unbroken(`${verdict}: ${shown}`));
      line.classList.add(verdict === "not judged" ? "unjudged" : verdict);
      if (advice !== "") line.append(small(advice));
      return line;
    }));
    part("live-difference").textContent = state.difference_px === null ? "" : TEXTS.difference(state.difference_px);
  }

  // Once for each rise after which the joint is within the tolerance.
  private tellBySound({ place, rises, moves }: LiveStateMessage): void {
    const said = place?.verdict === "within" ? `${moves} ${rises.length}` : "";
    if (said !== "" && said !== this.chimed) this.chime.ring();
    this.chimed = said;
    part("live-sound").dataset.rung = String(this.chime.rung);
  }

  private showPlace({ place, change, is_named, why_no_rise }: LiveStateMessage): void {
    part("live-place").className = place ? place.verdict : "";
    part("live-move").textContent = place ? unbroken(place.move) : is_named ? TEXTS.measuring : "";
    part("live-verdict").textContent = place ? TEXTS.toleranceText(place, this.message.tolerance_mm) : "";
    part("live-detail").textContent = place
      ? TEXTS.placeDetail(place.rises, place.where, Math.max(...place.anatomical_half_width_mm), this.message.joint_at_mm)
      : why_no_rise;
    part("live-change").textContent = unbroken(change);
  }
}

// Two short tones, for those who look at the straps. A browser gives sound only after a click: turning it on is one.
class Chime {
  rung = 0;
  private audio: AudioContext | null = null;

  turn(isOn: boolean): void {
    if (isOn) {
      this.audio = new AudioContext();
      this.ring(); // how it sounds
    } else {
      void this.audio?.close();
      this.audio = null;
    }
  }

  ring(): void {
    if (!this.audio) return;
    const TONE_S = 0.18, LOUDNESS = 0.2;
    for (const [index, pitch_hz] of [660, 880].entries()) {
      const from_s = this.audio.currentTime + index * TONE_S;
      const tone = new OscillatorNode(this.audio, { frequency: pitch_hz });
      const volume = new GainNode(this.audio, { gain: 0 });
      volume.gain.setValueAtTime(0, from_s);
      volume.gain.linearRampToValueAtTime(LOUDNESS, from_s + 0.01); // no click
      volume.gain.linearRampToValueAtTime(0, from_s + TONE_S);
      tone.connect(volume).connect(this.audio.destination);
      tone.start(from_s);
      tone.stop(from_s + TONE_S);
    }
    ++this.rung;
  }
}

function small(text: string): HTMLElement {
  const made = document.createElement("small");
  made.textContent = unbroken(text);
  return made;
}
