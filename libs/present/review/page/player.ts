// A button that plays what a page shows, and pauses it.
import { onClick, part } from "./dom";
import { TEXTS } from "./texts";

export class Player {
  private timer: number | undefined;

  /** `begin` gives the step that is then done again and again. */
  constructor(private readonly id: string, private readonly everyMs: number, private readonly begin: () => () => void) {
    part(id).textContent = TEXTS.play;
    onClick(id, () => this.toggle());
  }

  toggle(): void {
    const isPlaying = this.timer !== undefined;
    window.clearInterval(this.timer);
    this.timer = isPlaying ? undefined : window.setInterval(this.begin(), this.everyMs);
    part(this.id).textContent = isPlaying ? TEXTS.play : TEXTS.pause;
  }
}
