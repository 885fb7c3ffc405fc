// What the page and the server tell each other. The server's side is src/review.cc, trial_session.cc, trial_json.cc and
// design_explorer.cc; the naming of markers comes from lake::reviewing (naming_review.cc), a live session from lake::live
// (session_page.cc).

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
  moved: boolean; // by a person, from where it was found
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

export interface JobMessage {
  running: boolean;
  progress: string; // the last line that it said
  failed: string; // why the last one failed, or empty
}

export interface StateMessage {
  mode: "trial" | "naming" | "tracking" | "design" | "comparison" | "study" | "live" | "start";
  number: number; // grows with every state that the server gives
  job?: JobMessage; // tracking, optimising, a calibration or study that the start page asked for
  optimum?: { number: number; links: number[] } | null; // of a design: the last one found
  revision?: number; // counts changes
  fitted?: number; // the revision that the curves are of
  fit_error?: string;
  can_undo?: boolean;
  can_redo?: boolean;
  corrections?: number;
  swaps?: number; // among the steps that made these
  is_applied?: boolean; // the folder's results were made with them
}

export interface MeasureMessage {
  kind: "angle" | "distance" | "speed";
  name: string;
  markers: string[]; // three, two, one
}

export interface CourseMessage {
  measure: MeasureMessage;
  unit: string; // deg, mm, px, mm_s, px_s
  value: Column;
  sd: Column;
}

export interface AboutMessage {
  name: string;
  folder: string;
  command: string; // tracks with the corrections …
  command_with_events: string; // … and with events that were moved
  can_apply: boolean; // from the page
  warnings: string[]; // of the run that tracked it
  measures: MeasureMessage[]; // that it was tracked with
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
  | { op: "move_event"; repetition: number; event: string; frame: number }
  | { op: "restore_event"; repetition: number; event: string }
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
  path: [number, number][]; // px
}

export interface NamingMessage {
  name: string;
  frame: number;
  width: number;
  height: number;
  frames: number | null; // of the video, if it says
  trial_there: string; // the folder that tracking would replace, or empty
  camera_beside: string; // a camera file beside the video; empty: none
  detectors: string[]; // kinds of markers; the first is the usual one
  spots: SpotMessage[];
  choices: Choices; // to begin with
}

/** Other options of `lake track`, as its command line has them; empty where not given. */
export interface TrackOptions {
  camera?: string;
  scale?: string;
  "plane-points"?: string;
  vertical?: string;
  crop?: string;
  detector?: string;
  polarity?: string;
  color?: string;
  start?: string;
  end?: string;
}

/** The options of `lake track`. */
export interface Choices {
  markers: string[];
  options: TrackOptions;
  seeds: { [name: string]: number | [number, number, number] }; // number of a spot, or a place (px) and its frame
}

/** A part of a leg, mm: a frustum along it. */
export interface LimbMessage {
  length: number;
  proximal_radius: number;
  distal_radius: number;
}

export interface DesignMessage {
  name: string;
  links: number[]; // l1 to l6, mm, as saved
  bounds: [number, number][];
  d_min: number; // mm
  standing_deg: number;
  torque_nm: number; // that the force balances
  tolerance_mm: number | null; // by which a build may be off in each length and still meet the limits
  limits: string; // where they are from
  notes: string[];
  body: { knee: Place; thigh: LimbMessage; shank: LimbMessage };
}

export type PinName = "thigh_pin" | "tip" | "shank_pin" | "mount";

/** [x, y], mm: origin at the linkage's joint, x anterior, y up; the shank hangs upright. */
export type Place = [number, number];

export type PoseMessage = { [pin in PinName]: Place } & {
  thigh: Place; // from knee to hip, of length 1
};

export interface DesignColumns {
  knee: Column; // degrees
  arm: Column; // mm per rad
  force: Column; // N
  transmission: Column; // degrees
}

export interface DesignCurves {
  stroke: number[]; // mm, of each row
  now: DesignColumns;
  saved: DesignColumns;
  poses: (PoseMessage | null)[];
}

export interface CheckMessage {
  name: string;
  unit: string;
  is_lower_limit: boolean;
  limit: number | null; // null: there is none
  value: number | null; // null: it cannot be evaluated
  slack: number | null; // to the limit, negative where it fails
  holds: boolean;
  asked: boolean; // else nobody asked for it, and it is only shown
  worst: { knee_deg?: number; percent?: number } | null; // the pose in which it is nearest to its limit
}

export interface ExploreQuestion {
  links: number[];
  drag?: { pin: PinName; x: number; y: number; stroke: number };
  builds?: boolean; // of the worst build within the tolerance, which takes a second
}

export interface ExploredMessage {
  links: number[]; // after the pin was dragged
  stroke: number | null; // at which the other pins are where they were …
  pose: PoseMessage | null; // … and the pose there
  range_deg: number | null;
  stands: number | null; // stroke, mm
  gap: string; // why it cannot be assembled, or empty
  checks: CheckMessage[];
  of_builds: boolean; // the checks are of the worst build within the tolerance, else of the links as they are
  curves: DesignCurves | null; // null: it cannot be assembled
}

export interface ComparedVideoMessage {
  name: string;
  marker: string; // that is compared
  width: number; // px
  height: number;
  frame: number[]; // of each row
  repetition: Column;
  percent: Column;
  markers: { name: string; x: Column; y: Column }[];
  rises: RiseMessage[]; // that count in the comparison
}

/** The compared joint in the leg frame, mm, and the knee angle, a value per percent. */
export interface RiseMessage {
  repetition: number;
  x: number[];
  y: number[];
  knee_deg: number[];
}

/** A row per percent of the rise. */
export interface ComparisonCurves {
  percent: number[];
  distance_mm: Column;
  human_knee_deg: Column;
  exo_knee_deg: Column;
  spike: Column; // 1: left out of some metrics
  rms_mm: number;
  parts: Record<string, number>; // of the whole, 0 to 1
}

export interface ComparisonMessage {
  name: string;
  human: ComparedVideoMessage;
  exo: ComparedVideoMessage;
  curves: ComparisonCurves;
}

/** What of a study has a page of its own. */
export interface StudyPart {
  step: "human" | "exo" | "comparison" | "redesign" | "optimum";
  path: string;
}

export interface StudyMessage {
  name: string;
  command: string; // that made it
  report: string; // its file
  has_report: boolean;
  parts: StudyPart[];
}

/** What lies in a folder. */
export interface FoundMessage {
  path: string; // from the folder
  kind: "film" | "trial" | "comparison" | "design" | "study" | "study file" | "camera" | "picture" | "pictures" | "result" | "file";
  what: string;
  lacks: string; // what it still needs, or why it cannot be read; empty: nothing
}

export interface StartMessage {
  folder: string;
  found: FoundMessage[];
}

/** Paths are those of what was found. */
export type MakeQuestion =
  | { what: "camera"; views: string; board: string; plane: string }
  | { what: "study"; name: string; human: string; exo: string; worn: string; mass_kg: number;
      problem: string; percent: number; speed_mm_s: number; rise_s: number };

/** A camera's session, once. */
export interface LiveMessage {
  input: string;
  folder: string;
  width: number;
  height: number;
  markers: string[];
  joint: string; // of the markers
  joint_at_mm: Pair; // where that is against the joint's axis: anterior, along the shank
  tolerance_mm: number;
}

export type Pair = [number, number];

/** Of the rises since the joint was moved last. */
export interface LivePlace {
  rises: number;
  offset_mm: Pair; // joint less knee: anterior, along the shank
  half_width_mm: Pair;
  anatomical_half_width_mm: Pair;
  distance_mm: number;
  where: string;
  do_rises_narrow: boolean; // whether one more makes the interval narrower
  move: string; // what to do, in words
  verdict: "within" | "beyond" | "undecided";
}

export interface LiveStateMessage extends StateMessage {
  phase: "watching" | "trial" | "finishing" | "done" | "failed";
  is_held: boolean; // a film whose pictures come once the trial begins
  recorded_s: number;
  frames: number;
  moves: number;
  is_named: boolean;
  why_not_named: string;
  missing: string[]; // markers that are not seen now
  why_no_rise: string;
  rises: { standing_s: number; offset_mm: Pair; moves: number }[];
  place: LivePlace | null;
  change: string; // what the last move did, in words
  checks: { shown: string; verdict: string; advice: string }[];
  progress: string;
  end: string | null; // why no more frames come
  failed: string;
  has_trial: boolean; // also after a recording that was cut short by a full disk
  difference_px: number | null; // of the live positions to those of the trial, RMS
}

/** One frame, and the curves since the frame that was named. */
export interface LiveViewMessage {
  frame: number;
  time_s: number;
  arrived_ms: number; // since 1970
  markers: { name: string; x: number | null; y: number | null; sigma: number | null }[];
  spots: { x: number; y: number; radius: number; name: string }[];
  samples: [number, number | null, number | null, number | null][]; // s, knee degrees, joint less knee mm
  move: [Pair, Pair] | null; // from where the joint is to where it should be, px
}

export type LiveAct = { what: "begin" } | { what: "end" } | { what: "moved" } | { what: "name"; name: string; x: number; y: number };
