// What the page uses of Chart.js, whose package in Debian has no types.
declare module "chart.js" {
  export class Chart {
    constructor(canvas: HTMLCanvasElement, config: object);
    static register(...parts: unknown[]): void;
    static defaults: { font: object };
    ctx: CanvasRenderingContext2D;
    chartArea: { top: number; bottom: number };
    scales: { x: { getPixelForValue(value: number): number } };
    data: { datasets: object[] };
    options: { scales: { y: { min: number; max: number } }; plugins: { legend: { display: boolean } } };
    draw(): void;
    update(mode: "none"): void;
    destroy(): void;
  }
  export const Filler: unknown, Legend: unknown, LinearScale: unknown, LineController: unknown, LineElement: unknown,
    PointElement: unknown;
}
