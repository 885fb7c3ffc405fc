// Curves over the frames of a recording, in step with the frame that is shown. Each chart is as wide as the timeline, a
// column of pixels shows the range of all values in it, so a long recording hides no spike.
import { Column } from "./messages";

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

/** A canvas over the rows of the recording: where one clicks or drags, there the frame is shown. */
abstract class Strip {
  protected row = 0;

  constructor(protected canvas: HTMLCanvasElement, protected rows: number, protected seek: (row: number) => void) {
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.down(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0) this.drag(event);
    });
    canvas.addEventListener("pointerup", () => this.drop());
    canvas.addEventListener("pointercancel", () => this.cancel());
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  protected down(event: PointerEvent): void {
    this.seek(this.rowAt(event));
  }

  protected drag(event: PointerEvent): void {
    this.seek(this.rowAt(event));
  }

  protected drop(): void {}

  protected cancel(): void {}

  protected rowAt(event: PointerEvent): number {
    const x = event.clientX - this.canvas.getBoundingClientRect().left;
    return Math.round(Math.min(Math.max((x - LEFT) / this.width(), 0), 1) * (this.rows - 1));
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
    context.strokeStyle = colourOf("--accent");
    context.lineWidth = 1.5;
    line(context, this.x(this.row), 0, this.x(this.row), canvas.clientHeight);
  }

  protected abstract draw(context: CanvasRenderingContext2D): void;

  protected width(): number {
    return Math.max(this.canvas.clientWidth - LEFT - RIGHT, 1);
  }

  protected x(row: number): number {
    return LEFT + (this.rows > 1 ? row / (this.rows - 1) : 0) * this.width();
  }
}

function line(context: CanvasRenderingContext2D, x1: number, y1: number, x2: number, y2: number): void {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
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
export class Timeline extends Strip {
  private lanes: string[] = [];
  private marks: Mark[] = [];
  private ticks: Tick[] = [];
  private selected = -1;
  private held: { tick: number; row: number } | null = null;

  constructor(
    canvas: HTMLCanvasElement, private times: number[], seek: (row: number) => void,
    private take: (tick: number) => void,
    private move: (tick: number, row: number) => void,
  ) {
    super(canvas, times.length, seek);
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

  select(tick: number): void {
    this.selected = tick;
    this.redraw();
  }

  protected down(event: PointerEvent): void {
    const tick = this.tickAt(event);
    if (tick < 0) return super.down(event);
    this.held = { tick, row: this.ticks[tick].row };
    this.take(tick);
  }

  // The frame that is shown goes with the event.
  protected drag(event: PointerEvent): void {
    super.drag(event);
    if (this.held) this.held.row = this.rowAt(event);
  }

  protected drop(): void {
    const held = this.held;
    this.held = null;
    if (held && held.row !== this.ticks[held.tick].row) this.move(held.tick, held.row);
  }

  protected cancel(): void {
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

  protected draw(context: CanvasRenderingContext2D): void {
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

const NAMES = 20; // px above the curves, of their names

export class Chart extends Strip {
  private curves: Curve[] = [];

  show(curves: Curve[]): void {
    this.curves = curves;
    this.redraw();
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

  protected draw(context: CanvasRenderingContext2D): void {
    const [low, high] = this.range();
    const top = this.curves.length > 1 ? NAMES : 4, height = this.canvas.clientHeight - top - 4;
    const y = (value: number) => top + (1 - (value - low) / (high - low)) * height;
    this.drawAxis(context, low, high, y);
    for (const curve of this.curves) {
      if (curve.sigma) this.drawBand(context, curve, curve.sigma, y);
      this.drawCurve(context, curve, y);
    }
    this.drawNames(context);
  }

  // Of all values, a little wider; a single outlier does not flatten the rest.
  private range(): [number, number] {
    const values: number[] = [];
    for (const curve of this.curves) for (const value of curve.values) if (value !== null) values.push(value);
    if (values.length === 0) return [0, 1];
    values.sort((a, b) => a - b);
    const [low, high] = [0.002, 0.998].map((part) => values[Math.round(part * (values.length - 1))]);
    const margin = 0.06 * (high - low) || Math.abs(high) * 0.01 || 1;
    return [low - margin, high + margin];
  }

  private drawAxis(context: CanvasRenderingContext2D, low: number, high: number, y: (value: number) => number): void {
    const { step, digits } = roundStep((high - low) / 5);
    context.textBaseline = "middle";
    context.lineWidth = 1;
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      context.strokeStyle = colourOf("--rule");
      line(context, LEFT, y(value), LEFT + this.width(), y(value));
      context.fillStyle = colourOf("--quiet");
      // A label at the edge stays whole.
      const middle = Math.min(Math.max(y(value), 6), this.canvas.clientHeight - 6);
      context.fillText(value.toFixed(digits), 0, middle, LEFT - 4);
    }
  }

  // Within a column of pixels a vertical line from the least to the largest value, between columns the curve.
  private drawCurve(context: CanvasRenderingContext2D, curve: Curve, y: (value: number) => number): void {
    context.strokeStyle = colourOf(curve.colour);
    context.lineWidth = 1.5;
    context.beginPath();
    let isDown = false;
    let column: { x: number; least: number; most: number; last: number } | null = null;
    const end = () => {
      if (!column) return;
      context.moveTo(column.x, y(column.least));
      context.lineTo(column.x, y(column.most) - 0.5); // a value that stands alone is a dot
      context.moveTo(column.x, y(column.last));
    };
    for (let row = 0; row < curve.values.length; ++row) {
      const value = curve.values[row], x = Math.round(this.x(row));
      if (value === null) {
        isDown = false;
        continue;
      }
      if (column && column.x === x) {
        column.least = Math.min(column.least, value);
        column.most = Math.max(column.most, value);
        column.last = value;
      } else {
        end();
        if (isDown) context.lineTo(x, y(value));
        column = { x, least: value, most: value, last: value };
      }
      isDown = true;
    }
    end();
    context.stroke();
  }

  private drawBand(context: CanvasRenderingContext2D, curve: Curve, sigma: Column, y: (value: number) => number): void {
    context.strokeStyle = colourOf(curve.colour);
    context.globalAlpha = 0.3;
    context.lineWidth = Math.max(this.width() / this.rows, 1);
    context.beginPath();
    curve.values.forEach((value, row) => {
      const band = sigma[row];
      if (value === null || band === null) return;
      context.moveTo(this.x(row), y(value - 2 * band));
      context.lineTo(this.x(row), y(value + 2 * band));
    });
    context.stroke();
    context.globalAlpha = 1;
  }

  // In ink beside a piece of the curve: letters take more contrast than lines do.
  private drawNames(context: CanvasRenderingContext2D): void {
    const SWATCH = 10;
    if (this.curves.length < 2) return;
    let x = LEFT + 6;
    context.lineWidth = 2;
    context.fillStyle = colourOf("--ink");
    for (const curve of this.curves) {
      context.strokeStyle = colourOf(curve.colour);
      line(context, x, 10, x + SWATCH, 10);
      context.fillText(curve.name, x + SWATCH + 4, 10);
      x += SWATCH + 4 + context.measureText(curve.name).width + 12;
    }
  }
}
