// A picture that is zoomed and moved by mouse, fingers and keys, with something drawn over it.

export interface Point {
  x: number;
  y: number;
}

export const distance = (a: Point, b: Point) => Math.hypot(a.x - b.x, a.y - b.y);

/** Around a place of the screen. */
export function strokeCircle(context: CanvasRenderingContext2D, { x, y }: Point, radius: number): void {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.stroke();
}

export interface ViewActions {
  draw(context: CanvasRenderingContext2D, view: PictureView): void;
  /** Whether something is there to be dragged; `at` in px of the picture. */
  grab?(at: Point): boolean;
  drag?(at: Point): void;
  drop?(at: Point, free: boolean): void;
  click?(at: Point, free: boolean): void;
}

interface Label extends Point {
  width: number;
  draw: (at: Point) => void;
}

const LINE_HEIGHT = 16; // px, of labels

// Below those that it would cover. By less than a line, as rounding could else leave it where it is for ever.
function freeOf(labels: Label[], label: Label): Label {
  const covered = labels.find(({ x, y, width }) =>
    x < label.x + label.width && label.x < x + width && Math.abs(y - label.y) < LINE_HEIGHT - 0.5);
  return covered ? freeOf(labels, { ...label, y: covered.y + LINE_HEIGHT }) : label;
}

const MOST_ZOOM = 64; // screen px per px of the picture, over what fits

export class PictureView {
  private picture: ImageBitmap | null = null;
  private zoom = 1; // of what fits
  private centre: Point; // px of the picture, in the middle of the canvas
  private pointers = new Map<number, Point>();
  private grabbed = false;
  private moved = 0;
  private pinch = 0;
  private labels: Label[] = []; // of what is drawn now

  constructor(private canvas: HTMLCanvasElement, private size: Point, private actions: ViewActions) {
    this.centre = this.wholeCentre();
    canvas.style.aspectRatio = `${size.x} / ${size.y}`;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.up(event));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  show(picture: ImageBitmap): void {
    this.picture = picture;
    this.redraw();
  }

  /** The mean colour of the nine pixels there, #RRGGBB. */
  colourAt(at: Point): string {
    const one = document.createElement("canvas"), context = one.getContext("2d")!;
    one.width = one.height = 3;
    context.drawImage(this.picture!, 1 - Math.round(at.x), 1 - Math.round(at.y));
    const { data } = context.getImageData(0, 0, 3, 3), levels = [0, 0, 0];
    data.forEach((level, index) => {
      if (index % 4 < 3) levels[index % 4] += level / 9;
    });
    return `#${levels.map((level) => Math.round(level).toString(16).padStart(2, "0")).join("")}`;
  }

  /** Screen px per px of the picture. */
  scale(): number {
    return this.zoom * Math.min(this.canvas.clientWidth / this.size.x, this.canvas.clientHeight / this.size.y);
  }

  toScreen(at: Point): Point {
    const scale = this.scale();
    return {
      x: (at.x - this.centre.x) * scale + this.canvas.clientWidth / 2,
      y: (at.y - this.centre.y) * scale + this.canvas.clientHeight / 2,
    };
  }

  toPicture(at: Point): Point {
    const scale = this.scale();
    return {
      x: (at.x - this.canvas.clientWidth / 2) / scale + this.centre.x,
      y: (at.y - this.canvas.clientHeight / 2) / scale + this.centre.y,
    };
  }

  /** A line through these places of the picture, interrupted where one is not known. */
  strokeLine(context: CanvasRenderingContext2D, places: (Point | null)[]): void {
    context.beginPath();
    let isDown = false;
    for (const at of places) {
      if (at) {
        const { x, y } = this.toScreen(at);
        if (isDown) context.lineTo(x, y);
        else context.moveTo(x, y);
      }
      isDown = at !== null;
    }
    context.stroke();
  }

  /** A text with its left end at this place of the screen, or below the labels of higher places that it would cover. */
  label(context: CanvasRenderingContext2D, text: string, at: Point): void {
    const { font, fillStyle, globalAlpha } = context;
    const draw = ({ x, y }: Point) => {
      Object.assign(context, { font, fillStyle, globalAlpha, lineWidth: 3, strokeStyle: "rgba(0, 0, 0, 0.75)" });
      context.strokeText(text, x, y);
      context.fillText(text, x, y);
    };
    this.labels.push({ ...at, width: context.measureText(text).width, draw });
  }

  private drawLabels(): void {
    const placed: Label[] = [];
    for (const label of this.labels.sort((a, b) => a.y - b.y)) {
      placed.push(freeOf(placed, label));
      label.draw(placed[placed.length - 1]);
    }
  }

  middle(): Point {
    return { ...this.centre };
  }

  zoomBy(factor: number, at: Point = { x: this.canvas.clientWidth / 2, y: this.canvas.clientHeight / 2 }): void {
    const fixed = this.toPicture(at);
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), MOST_ZOOM);
    const now = this.toPicture(at);
    this.centreOn({ x: this.centre.x + fixed.x - now.x, y: this.centre.y + fixed.y - now.y });
  }

  /** Brings a place into the middle, at this zoom at least. */
  focus(at: Point, zoom: number): void {
    this.zoom = Math.max(this.zoom, zoom);
    this.centreOn(at);
  }

  fit(): void {
    this.zoom = 1;
    this.centreOn(this.wholeCentre());
  }

  redraw(): void {
    const canvas = this.canvas, ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const context = canvas.getContext("2d")!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    if (!this.picture) return;
    const scale = this.scale();
    // Pixel (0, 0) has its centre there.
    const corner = this.toScreen({ x: -0.5, y: -0.5 });
    context.imageSmoothingEnabled = scale < 4;
    context.drawImage(this.picture, corner.x, corner.y, this.size.x * scale, this.size.y * scale);
    this.labels = [];
    this.actions.draw(context, this);
    this.drawLabels();
  }

  private centreOn(at: Point): void {
    this.centre = {
      x: Math.min(Math.max(at.x, 0), this.size.x - 1),
      y: Math.min(Math.max(at.y, 0), this.size.y - 1),
    };
    if (this.zoom === 1) this.centre = this.wholeCentre();
    this.redraw();
  }

  private wholeCentre(): Point {
    return { x: (this.size.x - 1) / 2, y: (this.size.y - 1) / 2 };
  }

  private place(event: MouseEvent): Point {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private down(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.place(event);
    this.pointers.set(event.pointerId, at);
    this.moved = 0;
    this.grabbed = this.pointers.size === 1 && Boolean(this.actions.grab?.(this.toPicture(at)));
    this.pinch = this.spread();
  }

  private move(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const at = this.place(event);
    this.pointers.set(event.pointerId, at);
    this.moved += distance(at, before);
    if (this.grabbed) return this.actions.drag?.(this.toPicture(at));
    const scale = this.scale() * this.pointers.size;
    this.centreOn({ x: this.centre.x - (at.x - before.x) / scale, y: this.centre.y - (at.y - before.y) / scale });
    if (this.pointers.size === 2) {
      const spread = this.spread();
      if (this.pinch > 0) this.zoomBy(spread / this.pinch, this.between());
      this.pinch = spread;
    }
  }

  private up(event: PointerEvent): void {
    const at = this.toPicture(this.place(event));
    if (!this.pointers.delete(event.pointerId)) return;
    const isClick = this.moved < 4;
    if (this.grabbed && !isClick) this.actions.drop?.(at, event.altKey);
    else if (isClick && event.type === "pointerup") this.actions.click?.(at, event.altKey);
    this.grabbed = false;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.zoomBy(Math.exp(-event.deltaY / (event.deltaMode === 1 ? 15 : 400)), this.place(event));
  }

  private spread(): number {
    const [a, b] = [...this.pointers.values()];
    return a && b ? distance(a, b) : 0;
  }

  private between(): Point {
    const [a, b] = [...this.pointers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
  }
}
