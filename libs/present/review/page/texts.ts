// Every text of the page, in one place.
import { ProblemKind } from "./messages";

const EVENTS: { [event: string]: string } = {
  onset: "onset",
  seat_off: "seat-off",
  standing: "standing",
  descent: "descent",
  seated: "seated",
};

export const TEXTS = {
  // What the program is doing
  loading: "Loading the trial",
  fitting: "Fitting the leg",
  saved: (corrections: number) =>
    corrections === 0 ? "No corrections" : corrections === 1 ? "1 correction, saved" : `${corrections} corrections, saved`,
  ended: "lake review has ended; all corrections are saved. Start it again to go on.",
  noFit: (why: string) => `No leg can be fitted: ${why}`,

  // Frames
  frame: (frame: number, last: number, time_s: number) => `Frame ${frame} of ${last}, ${time_s.toFixed(3)} s`,
  play: "Play",
  pause: "Pause",
  event: (event: string, repetition: number) => `${EVENTS[event] ?? event} ${repetition}`,

  // Markers
  status: { d: "detected", f: "filled", m: "missing" } as { [status: string]: string },
  corrected: "corrected",
  position: (x: number, y: number, sigma: number) => `(${x.toFixed(2)}, ${y.toFixed(2)}) ± ${sigma.toFixed(2)} px`,
  placing: (marker: string) => `Click where ${marker} is; Esc ends it`,
  placedFree: (marker: string) => `${marker} placed where you pointed, ± 0.5 px: no marker was measured there`,
  snapped: (marker: string, x: number, y: number) => `${marker} snapped to (${x.toFixed(2)}, ${y.toFixed(2)})`,
  swapped: (one: string, other: string, frame: number) => `${one} and ${other} swapped from frame ${frame} on`,

  // Problems
  problem: (kind: ProblemKind, marker: string, first: number, last: number, value: number) => {
    const frames = first === last ? `frame ${first}` : `frames ${first} to ${last}`;
    switch (kind) {
      case "gap":
        return `${marker} not seen, ${frames}`;
      case "outlier":
        return `${marker} ${value.toFixed(1)} px off the fit, ${frames}`;
      case "uncertain":
        return `${marker} uncertain, ± ${value.toFixed(2)} px, ${frames}`;
      case "length":
        return `Segment below ${marker} ${value.toFixed(2)} times its usual length, ${frames}; names exchanged?`;
    }
  },
  kinds: { gap: "gap", outlier: "outlier", uncertain: "uncertain", length: "length" } as { [kind in ProblemKind]: string },
  problems: (count: number) => (count === 0 ? "No problems found" : count === 1 ? "1 problem" : `${count} problems`),
  noProblem: "There is no further problem in this direction",

  // Charts
  knee: "Knee angle (°)",
  lengths: "Segment lengths in the picture (% from their median)",
  residuals: "Residuals (px)",
  shank: "shank",
  thigh: "thigh",
  trunk: "trunk",

  // Naming
  finding: "Looking for markers",
  spot: (id: number, x: number, y: number, moves: boolean) =>
    `#${id} at (${x.toFixed(0)}, ${y.toFixed(0)})${moves ? "" : ", does not move"}`,
  choose: (name: string) => `Click ${name}`,
  pointAt: {
    scale: ["Click one end of the scale bar", "Click its other end"],
    vertical: ["Click one end of the plumb line", "Click its other end"],
    crop: ["Click one corner of the part to search", "Click the corner across"],
  },
  barLength: "Length of the scale bar (mm)",
  chooseDone: "All markers have their spots",
  tracking: "Tracking",
  trackingFailed: (why: string) => `Tracking ended without a result: ${why}`,
  copied: "Copied",
};
