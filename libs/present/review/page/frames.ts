// Pictures of frames as the browser keeps them: the one asked for last comes first, those after it follow.
const MOST_KEPT = 48;
const AHEAD = 6;
const LONGEST_STEP = 12; // beyond it a person jumped

export class Frames {
  private kept = new Map<number, ImageBitmap>();
  private loading = new Set<number>();
  private wanted = 0;
  private shown = -1; // the page may still draw it
  private step = 1;

  constructor(
    private fetched: (frame: number) => Promise<ImageBitmap>,
    private last: number, // nothing behind it is loaded ahead
    private loaded: (frame: number, picture: ImageBitmap) => void,
    private failed: (why: unknown) => void,
  ) {}

  has(frame: number): boolean {
    return this.kept.has(frame);
  }

  want(frame: number): void {
    const step = frame - this.wanted;
    this.step = Math.abs(step) > LONGEST_STEP || step === 0 ? Math.sign(step) || 1 : step;
    this.wanted = frame;
    const picture = this.kept.get(frame);
    if (picture) this.show(frame, picture);
    this.load();
  }

  private show(frame: number, picture: ImageBitmap): void {
    this.shown = frame;
    this.loaded(frame, picture);
  }

  // One picture at a time but when playing: while one scrubs, what was passed over is not asked for.
  private load(): void {
    const next = this.kept.has(this.wanted) ? this.firstMissing() : this.wanted;
    if (next === null || this.loading.has(next) || this.loading.size >= 2) return;
    this.loading.add(next);
    this.fetched(next)
      .then((picture) => {
        this.keep(next, picture);
        if (next === this.wanted) this.show(next, picture);
      })
      .catch((why) => {
        if (next === this.wanted) this.failed(why);
      })
      .finally(() => {
        this.loading.delete(next);
        if (this.kept.has(this.wanted) || next !== this.wanted) this.load();
      });
  }

  private firstMissing(): number | null {
    for (let i = 1; i <= AHEAD; ++i) {
      const frame = this.wanted + i * this.step;
      if (frame >= 0 && frame <= this.last && !this.kept.has(frame) && !this.loading.has(frame)) return frame;
    }
    return null;
  }

  private keep(frame: number, picture: ImageBitmap): void {
    this.kept.set(frame, picture);
    while (this.kept.size > MOST_KEPT) {
      const farthest = [...this.kept.keys()].filter((one) => one !== this.shown).reduce((a, b) =>
        Math.abs(a - this.wanted) > Math.abs(b - this.wanted) ? a : b,
      );
      this.kept.get(farthest)?.close();
      this.kept.delete(farthest);
    }
  }
}
