// A video alone: click the names onto the spots that the tracker sees, and let it track.
import { attempt, button, copyText, isOfControl, onClick, onKey, part, say, sayWhy, showProgress, undoOf } from "./dom";
import { Frames } from "./frames";
import { Choices, NamingMessage, SpotMessage, StateMessage, TrackOptions } from "./messages";
import { server } from "./server";
import { TEXTS } from "./texts";
import { PictureView, Point, distance, strokeCircle } from "./view";

const REACH = 25; // screen px
const FIFTH = "exo_knee"; // what a fifth marker is, of an exoskeleton trial

type Pointed = keyof typeof TEXTS.pointAt;

// Options that change which spots there are.
const OF_SPOTS = ["crop", "start", "end", "detector", "polarity", "color"];

export class NamingPage {
  private message: NamingMessage | null = null;
  private view: PictureView | null = null;
  private choices: Choices = { markers: [], seeds: {}, options: {} };
  private pointing: { option: Pointed; first: Point | null } | null = null;
  private frames: Frames | null = null;
  private selected = 0; // of the names; -1: none, all have their spots
  private past: Choices[] = [];
  private frame = 0; // that is shown
  private isTracking = false;
  private unfound = ""; // the marker that was not found by itself, until it is clicked
  private mayReplace = false; // a trial that is there

  constructor() {
    part("naming").hidden = false;
    part("state").textContent = TEXTS.finding;
    void this.find();
    onClick("start-tracking", () => void this.track());
    onClick("copy", () => void copyText("naming-command"));
    const names = part<HTMLInputElement>("names");
    names.addEventListener("change", () => this.rename(names.value));
    for (const field of document.querySelectorAll<HTMLInputElement>("[data-option]"))
      field.addEventListener("change", () => this.setOption(field.dataset.option as keyof TrackOptions, field.value));
    for (const pointer of document.querySelectorAll<HTMLElement>("[data-point]"))
      pointer.addEventListener("click", () => this.point(pointer.dataset.point as Pointed));
    onKey((event) => {
      if (event.key === "Escape") this.pointing = null;
      return undoOf(event) > 0 && !isOfControl(event) ? () => this.undo() : null;
    });
    onClick("naming-undo", () => this.undo());
    onClick("camera-beside", () => {
      this.fill("camera", this.message!.camera_beside);
      this.setOption("camera", this.message!.camera_beside);
    });
    const scrub = part<HTMLInputElement>("naming-scrub");
    scrub.addEventListener("input", () => this.seek(Number(scrub.value)));
  }

  private seek(frame: number): void {
    part<HTMLInputElement>("naming-scrub").value = String(frame);
    this.frames?.want(frame);
  }

  private remember(): void {
    this.past.push({ ...this.choices, markers: [...this.choices.markers], seeds: { ...this.choices.seeds } });
  }

  private undo(): void {
    const before = this.past.pop();
    if (!before) return;
    this.choices = { ...before, options: this.choices.options };
    part<HTMLInputElement>("names").value = this.choices.markers.join(", ");
    this.chooseNext();
    this.showChoices(TEXTS.done.undo);
  }

  // The next name without a spot; none where all have one: then no click changes anything.
  private chooseNext(): void {
    this.selected = this.choices.markers.findIndex((marker) => !(marker in this.choices.seeds));
  }

  close(): void {
    part("naming").hidden = true;
  }

  update(state: StateMessage): void {
    if (state.mode === "tracking") this.showProgress(state.job?.progress ?? "");
    else if (this.isTracking && state.job?.failed) this.showFailed(state.job.failed);
    this.isTracking = state.mode === "tracking";
    part("progress").hidden = !this.isTracking;
    part<HTMLButtonElement>("start-tracking").disabled = this.isTracking || !this.message;
    if (!this.isTracking && this.message) part("state").textContent = TEXTS.spots(this.message.spots.length);
  }

  // lake track says for which marker it asks.
  private showFailed(why: string): void {
    const asked = [...why.matchAll(/--seed (\w+)=/g)].map(([, name]) => name);
    this.unfound = asked.find((name) => this.choices.markers.includes(name) && !(name in this.choices.seeds)) ?? "";
    if (!this.unfound) return say(TEXTS.trackingFailed(why), true);
    this.selected = this.choices.markers.indexOf(this.unfound);
    this.showChoices();
  }

  private showProgress(line: string): void {
    part("state").textContent = line || TEXTS.tracking;
    showProgress(part<HTMLProgressElement>("progress"), line);
  }

  private async find(): Promise<void> {
    if (this.isOfPatches()) {
      this.message = { ...this.message!, spots: [] }; // a patch is wherever one points
      return this.showChoices();
    }
    part("state").textContent = TEXTS.finding;
    await attempt(async () => this.open(await server.naming(this.choices.options)));
  }

  private isOfPatches(): boolean {
    return this.choices.options.detector === "template";
  }

  private setOption(option: keyof TrackOptions, text: string): void {
    this.choices.options[option] = text.trim();
    if (!OF_SPOTS.includes(option)) return this.showChoices();
    this.choices.seeds = {}; // their numbers are of other spots
    this.past = [];
    this.selected = 0;
    void this.find();
  }

  private point(option: Pointed): void {
    this.pointing = { option, first: null };
    say(TEXTS.pointAt[option][0]);
  }

  private pointed(at: Point): void {
    const { option, first } = this.pointing!;
    if (option === "color") return this.pointedColour(at);
    if (option === "plane-points") return this.pointedKnown(at);
    if (!first) {
      this.pointing = { option, first: at };
      return say(TEXTS.pointAt[option][1]);
    }
    this.pointing = null;
    const round = (value: number) => Number(value.toFixed(1));
    let text = [first.x, first.y, at.x, at.y].map(round).join();
    if (option === "crop") {
      const [x, y] = [Math.min(first.x, at.x), Math.min(first.y, at.y)].map((value) => Math.max(Math.floor(value), 0));
      text = [x, y, Math.ceil(Math.max(first.x, at.x)) - x, Math.ceil(Math.max(first.y, at.y)) - y].join();
    } else if (option === "scale") {
      const length = window.prompt(TEXTS.barLength);
      if (length === null) return say(""); // cancelled: as if nothing had been pointed at
      text += `,${length}`;
    }
    this.fill(option, text);
    this.setOption(option, text);
  }

  // One point more, until Esc.
  private pointedKnown(at: Point): void {
    const place = window.prompt(TEXTS.planePlace);
    if (place === null) return say("");
    const before = this.choices.options["plane-points"] ?? "";
    const text = `${before ? `${before}; ` : ""}${at.x.toFixed(1)},${at.y.toFixed(1)}=${place.replace(/\s/g, "")}`;
    this.fill("plane-points", text);
    this.choices.options["plane-points"] = text;
    const count = text.split(";").length;
    if (count >= 4) this.showChoices(TEXTS.planePoints(count));
    else say(TEXTS.planePoints(count));
  }

  // A colour is that of markers that are found by their colours.
  private pointedColour(at: Point): void {
    this.pointing = null;
    const colour = this.view!.colourAt(at);
    this.fill("color", colour);
    this.fill("detector", "color");
    this.choices.options.detector = "color";
    this.setOption("color", colour);
  }

  private fill(option: keyof TrackOptions, text: string): void {
    document.querySelector<HTMLInputElement | HTMLSelectElement>(`[data-option=${option}]`)!.value = text;
  }

  private open(message: NamingMessage): void {
    const isFirst = !this.message;
    this.message = message;
    if (isFirst) {
      this.choices = message.choices;
      const kinds = message.detectors.map((name, i) => new Option(name, i > 0 ? name : ""));
      document.querySelector("[data-option=detector]")!.replaceChildren(...kinds);
    }
    part("name").textContent = message.name;
    document.title = `${message.name} – lake review`;
    part<HTMLInputElement>("names").value = this.choices.markers.join(", ");
    this.view ??= new PictureView(part("naming-picture"), { x: message.width, y: message.height }, {
      draw: (context) => this.draw(context),
      click: (at) => this.click(at),
    });
    const scrub = part<HTMLInputElement>("naming-scrub"), last = (message.frames ?? message.frame + 1) - 1;
    scrub.max = String(last);
    this.frames ??= new Frames(server.frame, last, (frame, picture) => {
      this.frame = frame;
      this.view!.show(picture);
    }, sayWhy);
    this.seek(message.frame);
    part("camera-beside").textContent = TEXTS.useCamera(message.camera_beside);
    this.showChoices();
  }

  private rename(text: string): void {
    this.remember();
    const names = text.split(",").map((name) => name.trim()).filter((name) => name !== "");
    const seeds: Choices["seeds"] = {};
    for (const name of names) if (name in this.choices.seeds) seeds[name] = this.choices.seeds[name];
    this.choices = { ...this.choices, markers: names, seeds };
    this.chooseNext();
    this.showChoices();
  }

  private click(at: Point): void {
    if (!this.message || this.isTracking) return;
    if (this.pointing) return this.pointed(at);
    if (this.isOfPatches()) return this.give([at.x, at.y, this.frame]);
    const reach = REACH / this.view!.scale();
    const near = this.message.spots
      .map((spot) => ({ spot, away: distance(spot, at) }))
      .filter(({ away }) => away < reach)
      .sort((a, b) => a.away - b.away)[0];
    if (near) this.assign(near.spot);
  }

  private assign(spot: SpotMessage): void {
    const name = this.choices.markers[this.selected];
    if (name === undefined) return say(TEXTS.chooseDone);
    const owner = this.choices.markers.find((other) => this.choices.seeds[other] === spot.id);
    if (owner !== undefined && owner !== name) return say(TEXTS.taken(spot.id, owner));
    this.give(spot.id);
  }

  private give(seed: Choices["seeds"][string]): void {
    const name = this.choices.markers[this.selected];
    if (name === undefined) return say(TEXTS.chooseDone);
    this.remember();
    this.choices.seeds[name] = seed;
    if (name === this.unfound) this.unfound = "";
    this.chooseNext();
    this.showChoices();
  }

  private addFifth(): void {
    this.remember();
    this.choices.markers = [...this.choices.markers, FIFTH];
    part<HTMLInputElement>("names").value = this.choices.markers.join(", ");
    this.chooseNext();
    this.showChoices();
  }

  private showChoices(said = ""): void {
    const { markers, seeds, options } = this.choices;
    const spotOf = (name: string) => this.message?.spots.find((spot) => spot.id === seeds[name]);
    const { spot: focusedSpot, name: focusedName } = (document.activeElement as HTMLElement | null)?.dataset ?? {};
    part("choices").replaceChildren(
      ...markers.map((name, index) => {
        const spot = spotOf(name);
        const seed = seeds[name];
        const made = button(Array.isArray(seed) ? TEXTS.seedAt(name, seed) : spot ? `${name}: #${spot.id}` : name, () => {
          this.selected = index;
          this.showChoices();
        });
        made.setAttribute("aria-pressed", String(index === this.selected));
        made.dataset.name = name;
        return made;
      }),
    );
    const isDone = markers.every((name) => name in seeds), spots = this.message?.spots.length ?? 0;
    if (isDone && !markers.includes(FIFTH) && spots > markers.length)
      part("choices").append(button(TEXTS.addMarker(FIFTH), () => this.addFifth()));
    part<HTMLButtonElement>("naming-undo").disabled = this.past.length === 0;
    part("camera-beside").hidden = !this.message?.camera_beside || Boolean(options.camera);
    part("spots").replaceChildren(
      ...(this.message?.spots ?? []).map((spot) => {
        const made = button(TEXTS.spot(spot.id, spot.x, spot.y, spot.frame, spot.moves), () => this.assign(spot));
        made.dataset.spot = String(spot.id);
        return made;
      }),
    );
    // Who has no mouse goes on from the same button.
    [...document.querySelectorAll<HTMLElement>("#choices button, #spots button")]
      .find(({ dataset }) => dataset.spot === focusedSpot && dataset.name === focusedName)
      ?.focus();
    part("ask").textContent =
      isDone ? TEXTS.chooseDone
      : markers[this.selected] === this.unfound ? TEXTS.unfound(this.unfound, spots)
      : TEXTS.choose(markers[this.selected]);
    part<HTMLButtonElement>("start-tracking").disabled = this.isTracking;
    part("start-tracking").textContent = this.mayReplace ? TEXTS.replaceTrial : TEXTS.track;
    this.view?.redraw();
    say(said);
    if (this.isOfPatches() && !isDone) {
      part("naming-command").textContent = ""; // each patch must be pointed at
      return;
    }
    server.command(this.choices).then(({ command }) => (part("naming-command").textContent = command), sayWhy);
  }

  private async track(): Promise<void> {
    const { trial_there } = this.message!;
    if (trial_there && !this.mayReplace) {
      this.mayReplace = true;
      this.showChoices(TEXTS.trialThere(trial_there));
      return;
    }
    say("");
    return attempt(async () => this.update(await server.track(this.choices)));
  }

  private draw(context: CanvasRenderingContext2D): void {
    const names = new Map(Object.entries(this.choices.seeds).map(([name, id]) => [id, name]));
    for (const [name, seed] of Object.entries(this.choices.seeds)) {
      if (!Array.isArray(seed)) continue;
      const at = this.view!.toScreen({ x: seed[0], y: seed[1] });
      context.strokeStyle = context.fillStyle = "#56B4E9";
      context.setLineDash(seed[2] === this.frame ? [] : [3, 4]);
      strokeCircle(context, at, 8);
      this.view!.label(context, name, { x: at.x + 10, y: at.y - 4 });
    }
    context.setLineDash([]);
    context.font = "bold 13px system-ui, sans-serif";
    const spots = this.message?.spots ?? [];
    const radiusOf = (spot: SpotMessage) => Math.max(spot.radius * this.view!.scale() + 4, 8);
    const colour = (spot: SpotMessage) => (names.has(spot.id) ? "#56B4E9" : spot.moves ? "#F0E442" : "#BBBBBB");
    for (const spot of spots) {
      const { x, y } = this.view!.toScreen(spot), name = names.get(spot.id);
      context.strokeStyle = colour(spot);
      context.lineWidth = 1;
      if (spot.moves) this.view!.strokeLine(context, spot.path.map(([px, py]) => ({ x: px, y: py })));
      context.lineWidth = name ? 3 : 1.5;
      context.setLineDash(spot.frame === this.frame ? [] : [3, 4]); // seen there in another frame
      strokeCircle(context, { x, y }, radiusOf(spot));
      context.setLineDash([]);
    }
    // Over the rings of all spots.
    for (const spot of spots) {
      const { x, y } = this.view!.toScreen(spot), name = names.get(spot.id);
      context.fillStyle = colour(spot);
      this.view!.label(context, name ? `${name} #${spot.id}` : `${spot.id}`, { x: x + radiusOf(spot) + 2, y: y - 4 });
    }
  }
}
