// Angles, distances and speeds of any markers: the server measures them as lake track does. What is asked for stays in
// the page's address.
import { Chart } from "./charts";
import { attempt, button, onClick, part, sayWhy } from "./dom";
import { CourseMessage, MeasureMessage } from "./messages";
import { server } from "./server";
import { TEXTS } from "./texts";

const MARKERS = { angle: 3, distance: 2, speed: 1 };
const ADDRESS = "#measures=";

export class Measures {
  private asked: MeasureMessage[];
  private courses: CourseMessage[] = [];
  private charts: Chart[] = [];
  private titles: HTMLElement[] = [];
  private row = 0;

  /** `changed` gets what the command line says of those that were added. */
  constructor(
    markers: string[], private given: MeasureMessage[], private rows: number,
    private seek: (row: number) => void, private changed: () => void,
  ) {
    this.asked = measuresOfAddress() ?? [...given];
    this.kind().addEventListener("change", () => this.showChoices());
    this.choices().forEach((choice, index) => {
      choice.replaceChildren(...markers.map((name) => new Option(name, name)));
      choice.selectedIndex = Math.min(index, markers.length - 1);
    });
    this.showChoices();
    onClick("measure", () => void this.add());
  }

  /** Asks anew: a marker may have been moved. */
  ask(): Promise<void> {
    return attempt(async () => {
      this.courses = this.asked.length === 0 ? [] : await server.measure(this.asked);
      this.show();
    });
  }

  showRow(row: number): void {
    this.row = row;
    this.courses.forEach((course, index) => (this.titles[index].textContent = TEXTS.measured(course, row)));
    for (const chart of this.charts) chart.showRow(row);
  }

  /** Those that were added or taken away since: whether the command says them all. */
  added(): MeasureMessage[] {
    const known = this.given.map((measure) => JSON.stringify(measure));
    return this.asked.filter((measure) => !known.includes(JSON.stringify(measure)));
  }

  private kind(): HTMLSelectElement {
    return part<HTMLSelectElement>("measure-kind");
  }

  private choices(): HTMLSelectElement[] {
    return ["first", "second", "third"].map((which) => part<HTMLSelectElement>(`measure-${which}`));
  }

  private showChoices(): void {
    const count = MARKERS[this.kind().value as MeasureMessage["kind"]];
    this.choices().forEach((choice, index) => (choice.hidden = index >= count));
  }

  private async add(): Promise<void> {
    const kind = this.kind().value as MeasureMessage["kind"];
    const markers = this.choices().slice(0, MARKERS[kind]).map((choice) => choice.value);
    if (new Set(markers).size < markers.length) return sayWhy(TEXTS.sameMarkers);
    const name = [...markers, kind].join("_");
    if (this.asked.some((measure) => measure.name === name)) return;
    await this.change([...this.asked, { kind, name, markers }]);
  }

  private async change(asked: MeasureMessage[]): Promise<void> {
    this.asked = asked;
    const isGiven = JSON.stringify(asked) === JSON.stringify(this.given);
    history.replaceState(null, "", isGiven ? "#" : ADDRESS + encodeURIComponent(JSON.stringify(asked)));
    this.changed();
    await this.ask();
  }

  private show(): void {
    for (const chart of this.charts) chart.end();
    this.charts = [];
    this.titles = [];
    part("measures").replaceChildren(...this.courses.map((course) => this.block(course)));
    this.charts.forEach((chart, index) => {
      const { value, sd } = this.courses[index];
      chart.show([{ name: "", colour: "--accent", values: value, sigma: sd }]);
    });
    this.showRow(this.row);
  }

  private block(course: CourseMessage): HTMLElement {
    const block = document.createElement("div"), bar = document.createElement("div");
    const title = document.createElement("h2"), canvas = document.createElement("canvas");
    const { name } = course.measure;
    title.id = `measure-${this.titles.length}`;
    canvas.className = "chart";
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-labelledby", title.id);
    const remove = button(TEXTS.remove, () => void this.change(this.asked.filter((measure) => measure.name !== name)));
    remove.setAttribute("aria-label", TEXTS.removeMeasure(name));
    bar.className = "bar";
    bar.append(title, remove);
    block.dataset.measure = name;
    block.append(bar, canvas);
    this.titles.push(title);
    this.charts.push(new Chart(canvas, this.rows, this.seek));
    return block;
  }
}

function measuresOfAddress(): MeasureMessage[] | null {
  if (!location.hash.startsWith(ADDRESS)) return null;
  try {
    return JSON.parse(decodeURIComponent(location.hash.slice(ADDRESS.length))) as MeasureMessage[];
  } catch {
    return null; // an address that somebody cut
  }
}
