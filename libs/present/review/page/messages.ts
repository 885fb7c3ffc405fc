// What the page and the server tell each other. The server's side is src/review.cc, trial_session.cc and trial_json.cc;
// the naming of markers comes from lake::commands (review_naming.cc).

/** A column has one value per row of the recording; null where there is none. */
export type Column = (number | null)[];

export interface MarkerMessage {
  name: string;
  x: Column; // px in the picture, centre of the top left pixel (0, 0)
  y: Column;
  sigma: Column; // px, one standard deviation per axis
  status: string; // by row: d detected, f filled by the fit, m missing
  corrected: number[]; // rows
  residual: Column; // px, measurement to fit
}

export interface EventMessage {
  repetition: number;
  event: string;
  frame: number;
}

export interface LegMessage {
  knee: Column; // degrees
  knee_sigma: Column;
  events: EventMessage[];
}

export type ProblemKind = "gap" | "outlier" | "uncertain" | "length";

export interface ProblemMessage {
  kind: ProblemKind;
  marker: string;
  first: number; // frames
  last: number;
  value: number;
}

export interface StateMessage {
  mode: "trial" | "naming" | "tracking";
  progress: string; // of tracking
  failed: string; // why tracking ended without a trial
  revision?: number; // counts changes
  fitted?: number; // the revision that the curves are of
  fit_error?: string;
  can_undo?: boolean;
  can_redo?: boolean;
  corrections?: number;
}

export interface AboutMessage {
  name: string;
  folder: string;
  command: string; // tracks with the corrections
  width: number; // px
  height: number;
}

export interface TrialMessage {
  frame: number[]; // of each row
  time_s: number[];
  markers: MarkerMessage[];
  leg: LegMessage | null;
  warnings: string[];
  problems: ProblemMessage[];
  state: StateMessage;
  about: AboutMessage;
}

export type EditMessage =
  | { op: "place"; frame: number; marker: string; x: number; y: number; sigma?: number }
  | { op: "hide" | "restore"; frame: number; marker: string }
  | { op: "swap"; frame: number; marker: string; other: string }
  | { op: "undo" | "redo" };

export interface SnapQuestion {
  frame: number;
  marker: string; // empty: of none yet
  x: number;
  y: number;
  reach: number; // px
}

export type SnapAnswer = { x: number; y: number; sigma: number } | null;

export interface SpotMessage {
  id: number;
  frame: number;
  x: number;
  y: number;
  radius: number; // px
  moves: boolean;
}

export interface NamingMessage {
  name: string;
  frame: number;
  width: number;
  height: number;
  spots: SpotMessage[];
  choices: Choices; // to begin with
}

/** Other options of `lake track`, as its command line has them; empty where not given. */
export interface TrackOptions {
  camera?: string;
  scale?: string;
  vertical?: string;
  crop?: string;
  detector?: string;
  polarity?: string;
  color?: string;
  start?: string;
  end?: string;
}

/** What `lake track` is told. */
export interface Choices {
  markers: string[];
  options: TrackOptions;
  seeds: { [name: string]: number }; // numbers of spots
}
