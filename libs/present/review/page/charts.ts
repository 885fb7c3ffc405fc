// Curves over the frames of a recording, in step with the frame that is shown, and the timeline above them. Each chart
// is as wide as the timeline; where a pixel has several values it shows the least and the largest, so that a long
// recording hides no spike.
import { Chart as ChartJs, Filler, Legend, LinearScale, LineController, LineElement, PointElement } from "chart.js";
import { Column } from "./messages";

ChartJs.register(Filler, Legend, LinearScale, LineController, LineElement, PointElement);
ChartJs.defaults.font = { family: "system-ui, sans-serif", size: 11 };

export interface Curve {
  name: string;
  colour: string;
  values: Column;
  sigma?: Column; // drawn as a band of two of them on either side
}

export interface Mark {
  first: number; // rows
  last: number;
  colour: string;
  lane: number; // from the top
}

export interface Tick {
  row: number;
  label: string;
  moved: boolean; // by a person
}

const LEFT = 46, RIGHT = 6; // px beside the curves

export const colourOf = (name: string) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Where one clicks or drags on the canvas, there the frame is shown. */
function seekOn(canvas: HTMLCanvasElement, down: (event: PointerEvent) => void, drag: (event: PointerEvent) => void): void {
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons !== 0) drag(event);
  });
}

function rowAt(event: PointerEvent, rows: number): number {
  const box = (event.target as HTMLElement).getBoundingClientRect();
  return Math.round(Math.min(Math.max((event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT), 0), 1) * (rows - 1));
}

function line(context: CanvasRenderingContext2D, x1: number, y1: number, x2: number, y2: number): void {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

// Of the frame that is shown.
function drawCursor(context: CanvasRenderingContext2D, x: number, top: number, bottom: number): void {
  context.strokeStyle = colourOf("--accent");
  context.lineWidth = 1.5;
  line(context, x, top, x, bottom);
}

/** The next round number for the step of an axis, and the digits of its labels. */
function roundStep(rough: number): { step: number; digits: number } {
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((part) => part * power).find((candidate) => candidate >= rough) ?? rough;
  return { step, digits: Math.max(0, -Math.floor(Math.log10(step))) };
}

const LANE = 13, HANDLES = 18, AXIS = 15; // px, of a marker's lane, of the strip with the events below, of the times
const HOLD = 9; // px beside an event in which it is taken hold of

/** Where the problems are, a lane for each marker, and the events, which can be dragged by what is below the lanes. */
export class Timeline {
  private row = 0;
  private lanes: string[] = [];
  private marks: Mark[] = [];
  private ticks: Tick[] = [];
  private selected = -1;
  private held: { tick: number; row: number } | null = null;

  constructor(
    private canvas: HTMLCanvasElement, private times: number[], private seek: (row: number) => void,
    private take: (tick: number) => void,
    private move: (tick: number, row: number) => void,
  ) {
    seekOn(canvas, (event) => this.down(event), (event) => this.drag(event));
    canvas.addEventListener("pointerup", () => this.drop());
    canvas.addEventListener("pointercancel", () => this.cancel());
    new ResizeObserver(() => this.redraw()).observe(canvas);
    canvas.addEventListener("pointermove", (event) => {
      canvas.style.cursor = this.held || this.tickAt(event) >= 0 ? "ew-resize" : "";
    });
  }

  show(lanes: string[], marks: Mark[], ticks: Tick[]): void {
    if (ticks.length !== this.ticks.length) this.held = null; // else the new fit does not take an event out of the hand
    this.lanes = lanes;
    this.marks = marks;
    this.ticks = ticks;
    this.canvas.style.height = `${lanes.length * LANE + HANDLES + AXIS}px`;
    this.redraw();
  }

  showRow(row: number): void {
    this.row = row;
    this.redraw();
  }

  redraw(): void {
    const ratio = window.devicePixelRatio || 1, canvas = this.canvas;
    if (canvas.clientWidth === 0) return;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    const context = canvas.getContext("2d")!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "11px system-ui, sans-serif";
    this.draw(context);
    drawCursor(context, this.x(this.row), 0, canvas.clientHeight);
  }

  private width(): number {
    return Math.max(this.canvas.clientWidth - LEFT - RIGHT, 1);
  }

  private x(row: number): number {
    return LEFT + (this.times.length > 1 ? row / (this.times.length - 1) : 0) * this.width();
  }

  select(tick: number): void {
    this.selected = tick;
    this.redraw();
  }

  private down(event: PointerEvent): void {
    const tick = this.tickAt(event);
    if (tick < 0) return this.seek(rowAt(event, this.times.length));
    this.held = { tick, row: this.ticks[tick].row };
    this.take(tick);
  }

  // The frame that is shown goes with the event.
  private drag(event: PointerEvent): void {
    const row = rowAt(event, this.times.length);
    this.seek(row);
    if (this.held) this.held.row = row;
  }

  private drop(): void {
    const held = this.held;
    this.held = null;
    if (held && held.row !== this.ticks[held.tick].row) this.move(held.tick, held.row);
  }

  private cancel(): void {
    this.held = null;
    this.redraw();
  }

  // The nearest within reach, or -1.
  private tickAt(event: PointerEvent): number {
    const box = this.canvas.getBoundingClientRect();
    if (event.clientY - box.top < this.lanes.length * LANE) return -1;
    const away = this.ticks.map((tick) => Math.abs(this.x(tick.row) - (event.clientX - box.left)));
    const nearest = away.indexOf(Math.min(...away));
    return nearest >= 0 && away[nearest] <= HOLD ? nearest : -1;
  }

  private draw(context: CanvasRenderingContext2D): void {
    context.fillStyle = colourOf("--quiet");
    context.textBaseline = "middle";
    context.strokeStyle = colourOf("--rule");
    context.lineWidth = 1;
    this.lanes.forEach((name, lane) => {
      const y = lane * LANE + 7;
      context.fillText(name, 0, y, LEFT - 4);
      line(context, LEFT, y, LEFT + this.width(), y);
    });
    for (const mark of this.marks) {
      const from = this.x(mark.first - 0.5);
      context.fillStyle = mark.colour;
      context.fillRect(from, mark.lane * LANE + 2, Math.max(this.x(mark.last + 0.5) - from, 3), 10);
    }
    this.drawTicks(context);
    this.drawTimes(context);
  }

  // The one time axis, which timeline and curves share.
  private drawTimes(context: CanvasRenderingContext2D): void {
    const first = this.times[0], last = this.times[this.times.length - 1], y = this.canvas.clientHeight - AXIS / 2;
    const { step, digits } = roundStep((last - first) / Math.max(this.width() / 80, 1));
    context.fillStyle = colourOf("--quiet");
    context.strokeStyle = colourOf("--rule");
    context.lineWidth = 1;
    let row = 0;
    for (let time = Math.ceil(first / step) * step; time <= last; time += step) {
      while (row + 1 < this.times.length && this.times[row] < time) ++row;
      const label = `${time.toFixed(digits)} s`, x = this.x(row), width = context.measureText(label).width;
      line(context, x, y - AXIS / 2, x, y - AXIS / 2 + 3);
      context.fillText(label, Math.min(Math.max(x - width / 2, LEFT), this.canvas.clientWidth - width), y + 2);
    }
  }

  private drawTicks(context: CanvasRenderingContext2D): void {
    const below = this.lanes.length * LANE;
    const circles = this.ticks.map((tick) => this.x(tick.row));
    let free = 0; // labels cover neither each other nor circles
    this.ticks.forEach((tick, index) => {
      const isHeld = this.held?.tick === index;
      const x = this.x(isHeld ? this.held!.row : tick.row), width = context.measureText(tick.label).width;
      const colour = colourOf(isHeld || index === this.selected ? "--accent" : tick.moved ? "--ink" : "--quiet");
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = isHeld || index === this.selected ? 2 : 1;
      line(context, x, 0, x, below + 4);
      context.beginPath();
      context.arc(x, below + 9, 4, 0, 2 * Math.PI);
      if (tick.moved) context.fill();
      context.stroke();
      if (x < free || circles.some((other) => other > x && other < x + width + 13)) return;
      if (x + 7 + width > this.canvas.clientWidth) return; // over its own circle
      context.fillText(tick.label, x + 7, below + 10);
      free = x + width + 13;
    });
  }
}

const PARTS = 1500; // in which a long curve keeps its least and its largest value
const KEPT_SHARE = 0.996; // of all values: single outliers do not flatten the rest

interface Point {
  x: number; // row
  y: number; // NaN: a gap
}

function pointsOf(values: Column): Point[] {
  const length = Math.max(1, values.length / PARTS), points: Point[] = [];
  const add = (row: number) => points.push({ x: row, y: values[row] ?? NaN });
  for (let from = 0; from < values.length; from += length) {
    const first = Math.ceil(from), last = Math.min(Math.ceil(from + length), values.length);
    let least = -1, most = -1, gap = -1;
    for (let row = first; row < last; ++row) {
      const value = values[row];
      if (value === null || value === undefined) gap = row;
      else {
        if (least < 0 || value < values[least]!) least = row;
        if (most < 0 || value > values[most]!) most = row;
      }
    }
    [...new Set([least, most, gap])].filter((row) => row >= 0).sort((a, b) => a - b).forEach(add);
  }
  return points;
}

// A little wider than nearly all values.
function rangeOf(curves: Curve[]): [number, number] {
  const values = Float64Array.from(curves.flatMap((curve) => curve.values.filter((value) => value !== null) as number[])).sort();
  if (values.length === 0) return [0, 1];
  const at = (part: number) => values[Math.round(part * (values.length - 1))];
  const low = at((1 - KEPT_SHARE) / 2), high = at((1 + KEPT_SHARE) / 2);
  const margin = 0.06 * (high - low) || Math.abs(high) * 0.01 || 1;
  return [low - margin, high + margin];
}

export class Chart {
  private curves: Curve[] = [];
  private row = 0;
  private chart: ChartJs;
  private ended = new AbortController();

  constructor(canvas: HTMLCanvasElement, private rows: number, seek: (row: number) => void) {
    const box = document.createElement("div"); // has the size: the canvas follows it
    box.className = canvas.className;
    canvas.replaceWith(box);
    box.append(canvas);
    const seekAt = (event: PointerEvent) => seek(rowAt(event, rows));
    seekOn(canvas, seekAt, seekAt);
    const quiet = () => colourOf("--quiet"), rule = () => colourOf("--rule");
    this.chart = new ChartJs(canvas, {
      type: "line",
      data: { datasets: [] },
      options: {
        animation: false, parsing: false, normalized: true, maintainAspectRatio: false, events: [],
        layout: { padding: { right: RIGHT } },
        scales: {
          x: { type: "linear", display: false, min: 0, max: Math.max(rows - 1, 1) },
          y: {
            grid: { color: rule, borderColor: rule },
            ticks: { color: quiet, maxTicksLimit: 6, includeBounds: false, format: { useGrouping: false } },
            afterFit: (scale: { width: number }) => (scale.width = LEFT),
          },
        },
        plugins: {
          legend: {
            align: "start",
            labels: { color: () => colourOf("--ink"), boxWidth: 10, boxHeight: 1, padding: 6, filter: ({ text }: { text: string }) => text !== "" },
          },
        },
      },
      plugins: [{
        afterDraw: ({ ctx, scales, chartArea }: ChartJs) =>
          drawCursor(ctx, scales.x.getPixelForValue(this.row), chartArea.top, chartArea.bottom),
      }],
    });
    matchMedia("(prefers-color-scheme: dark)")
      .addEventListener("change", () => this.chart.update("none"), { signal: this.ended.signal });
  }

  showRow(row: number): void {
    this.row = row;
    this.chart.draw();
  }

  show(curves: Curve[]): void {
    this.curves = curves;
    const thin = { pointRadius: 0, borderWidth: 0, label: "" };
    this.chart.data.datasets = curves.flatMap(({ name, colour, values, sigma }) => {
      const edge = (side: number) => pointsOf(values.map((value, row) => value === null ? null : value + side * (sigma![row] ?? NaN)));
      const band = !sigma ? [] : [
        { ...thin, data: edge(-2) },
        { ...thin, data: edge(2), fill: "-1", backgroundColor: () => `${colourOf(colour)}4d` },
      ];
      return [...band, {
        label: name, data: pointsOf(values), borderColor: () => colourOf(colour), borderWidth: 1.5, pointRadius: 0,
        backgroundColor: () => colourOf(colour),
      }];
    });
    const { y } = this.chart.options.scales;
    [y.min, y.max] = rangeOf(curves);
    this.chart.options.plugins.legend.display = curves.length > 1;
    this.chart.update("none");
  }

  /** Its canvas goes. */
  end(): void {
    this.ended.abort();
    this.chart.destroy();
  }

  /** Column by column after these: a curve by its name, or by this one if it has none, and its SD. */
  csv(columns: { [name: string]: Column }, name: string): string {
    const all = { ...columns };
    for (const curve of this.curves) {
      all[curve.name || name] = curve.values;
      if (curve.sigma) all[`${curve.name || name}_sd`] = curve.sigma;
    }
    const rows = Array.from({ length: this.rows }, (_, row) => Object.values(all).map((column) => column[row] ?? ""));
    return [Object.keys(all), ...rows].map((cells) => cells.join()).join("\n") + "\n";
  }
}
