// The leg with its linkage, zoomed and moved by mouse and fingers; a pin that is dragged says where. Places are the
// server's: nothing is computed of the mechanism here.
import { colourOf } from "./charts";
import { DesignMessage, LimbMessage, PinName, Place, PoseMessage } from "./messages";
import { TEXTS } from "./texts";
import { Point, distance } from "./view";

const PINS: PinName[] = ["thigh_pin", "tip", "shank_pin", "mount"];
const REACH = 16; // screen px
const WIDTH = 12; // of a link, mm

export interface LinkageActions {
  drag(pin: PinName, to: Place): void;
  drop(): void;
}

export class LinkageView {
  private pose: PoseMessage | null = null;
  private scale = 1; // screen px per mm
  private centre: Place = [0, 0]; // mm, in the middle of the canvas
  private dragged: PinName | null = null;
  private last: Point | null = null;

  constructor(
    private canvas: HTMLCanvasElement,
    private body: DesignMessage["body"],
    private actions: LinkageActions,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, () => this.up());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY / (event.deltaMode === 1 ? 15 : 400)));
    }, { passive: false });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  show(pose: PoseMessage | null): void {
    this.pose = pose;
    this.redraw();
  }

  /** The linkage in all these poses, and the whole leg. */
  fit(poses: PoseMessage[]): void {
    const { thigh, shank, knee } = this.body;
    const end = (limb: LimbMessage, along: Place): Place => [knee[0] + along[0] * limb.length, knee[1] + along[1] * limb.length];
    const places = poses.flatMap((pose) => [...PINS.map((pin) => pose[pin]), end(thigh, pose.thigh)]).concat([end(shank, [0, -1]), end(thigh, [0, 1])]);
    const [xs, ys] = [0, 1].map((axis) => places.map((place) => place[axis]));
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    this.centre = [(left + right) / 2, (low + high) / 2];
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.scale = Math.max(Math.min(width / (right - left + 90), height / (high - low + 90)), 0.1);
    this.redraw();
  }

  zoomBy(factor: number): void {
    this.scale = Math.min(Math.max(this.scale * factor, 0.1), 40);
    this.redraw();
  }

  private toScreen([x, y]: Place): Point {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return { x: width / 2 + (x - this.centre[0]) * this.scale, y: height / 2 - (y - this.centre[1]) * this.scale };
  }

  private at(event: PointerEvent): Point {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private down(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.at(event), pose = this.pose;
    this.last = at;
    if (!pose) return;
    const near = PINS.map((pin) => ({ pin, away: distance(this.toScreen(pose[pin]), at) })).sort((a, b) => a.away - b.away)[0];
    if (near.away < REACH) this.dragged = near.pin;
  }

  private move(event: PointerEvent): void {
    if (!this.last) return;
    const at = this.at(event), { x, y } = this.last;
    this.last = at;
    const by: Place = [(at.x - x) / this.scale, (y - at.y) / this.scale];
    if (this.dragged) {
      const middle = this.toScreen(this.centre);
      this.actions.drag(this.dragged, [
        this.centre[0] + (at.x - middle.x) / this.scale, this.centre[1] - (at.y - middle.y) / this.scale,
      ]);
    } else {
      this.centre = [this.centre[0] - by[0], this.centre[1] - by[1]];
      this.redraw();
    }
  }

  private up(): void {
    if (this.dragged) this.actions.drop();
    this.dragged = this.last = null;
  }

  // --- drawing

  redraw(): void {
    const canvas = this.canvas, ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    const context = canvas.getContext("2d")!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineCap = context.lineJoin = "round";
    const pose = this.pose;
    // Of a linkage that cannot be assembled the leg alone, standing.
    this.drawLimb(context, this.body.thigh, pose ? pose.thigh : [0, 1]);
    this.drawLimb(context, this.body.shank, [0, -1]);
    if (pose) this.drawLinkage(context, pose);
    this.showPlaces();
  }

  private drawLimb(context: CanvasRenderingContext2D, limb: LimbMessage, along: Place): void {
    const isThigh = limb === this.body.thigh;
    const atKnee = isThigh ? limb.distal_radius : limb.proximal_radius;
    const atEnd = isThigh ? limb.proximal_radius : limb.distal_radius;
    const turn = Math.atan2(along[1], along[0]), [x, y] = this.body.knee;
    const knee = this.toScreen([x, y]), far = this.toScreen([x + along[0] * limb.length, y + along[1] * limb.length]);
    context.beginPath();
    context.arc(far.x, far.y, atEnd * this.scale, -turn - Math.PI / 2, -turn + Math.PI / 2);
    context.arc(knee.x, knee.y, atKnee * this.scale, -turn + Math.PI / 2, -turn - Math.PI / 2);
    context.closePath();
    context.fillStyle = colourOf("--skin");
    context.strokeStyle = colourOf("--skin-edge");
    context.lineWidth = 1;
    context.globalAlpha = 0.85;
    context.fill();
    context.stroke();
    context.globalAlpha = 1;
  }

  private drawLinkage(context: CanvasRenderingContext2D, pose: PoseMessage): void {
    const knee: Place = [0, 0];
    this.drawPlate(context, [knee, pose.mount, pose.thigh_pin], "--l3", WIDTH);
    this.drawBar(context, [knee, pose.shank_pin], "--l4", WIDTH);
    this.drawBar(context, [pose.mount, pose.tip], "--quiet", WIDTH / 2);
    const [m, r] = [pose.mount, pose.tip];
    this.drawBar(context, [m, [m[0] + 0.55 * (r[0] - m[0]), m[1] + 0.55 * (r[1] - m[1])]], "--actuator", WIDTH * 1.3);
    this.drawBar(context, [pose.thigh_pin, pose.tip], "--l2", WIDTH);
    this.drawBar(context, [pose.tip, pose.shank_pin], "--l1", WIDTH);
    this.drawPin(context, knee, TEXTS.knee_pin, false);
    for (const pin of PINS) this.drawPin(context, pose[pin], TEXTS.pins[pin], true);
  }

  private drawBar(context: CanvasRenderingContext2D, places: Place[], colour: string, width: number): void {
    context.strokeStyle = colourOf(colour);
    context.lineWidth = Math.max(width * this.scale, 2);
    context.beginPath();
    for (const { x, y } of places.map((place) => this.toScreen(place))) context.lineTo(x, y);
    context.stroke();
  }

  /** As it is cut: round about its pins. */
  private drawPlate(context: CanvasRenderingContext2D, pins: Place[], colour: string, width: number): void {
    this.drawBar(context, [...pins, pins[0]], colour, width);
    context.fillStyle = colourOf(colour);
    context.fill();
  }

  private drawPin(context: CanvasRenderingContext2D, place: Place, name: string, isMovable: boolean): void {
    const { x, y } = this.toScreen(place);
    context.beginPath();
    context.arc(x, y, isMovable ? 6 : 4, 0, 2 * Math.PI);
    context.fillStyle = colourOf("--paper");
    context.strokeStyle = colourOf("--ink");
    context.lineWidth = 2;
    context.fill();
    context.stroke();
    context.font = "bold 13px system-ui, sans-serif";
    context.lineWidth = 3;
    context.strokeStyle = colourOf("--paper");
    context.strokeText(name, x + 10, y - 8);
    context.fillStyle = colourOf("--ink");
    context.fillText(name, x + 10, y - 8);
  }

  // Where the pins are on the canvas, for whoever looks at the page by program.
  private showPlaces(): void {
    for (const pin of PINS) {
      const at = this.pose && this.toScreen(this.pose[pin]);
      this.canvas.dataset[pin] = at ? `${at.x.toFixed(1)},${at.y.toFixed(1)}` : "";
    }
  }
}
