// Questions to the server that served this page; addresses are relative, so the token stays in them.
import {
  Choices, ComparisonMessage, CourseMessage, DesignMessage, EditMessage, ExploreQuestion, ExploredMessage, LiveAct,
  LiveMessage, LiveStateMessage, LiveViewMessage, MakeQuestion, MeasureMessage, NamingMessage, SnapAnswer, SnapQuestion,
  StartMessage, StateMessage, StudyMessage, TrackOptions, TrialMessage,
} from "./messages";

/** The server's own words on why not. */
export class Refused extends Error {}

async function answer<T>(response: Response): Promise<T> {
  const message = await response.json();
  if (!response.ok) throw new Refused(message.error);
  return message as T;
}

const get = async <T>(path: string): Promise<T> => answer<T>(await fetch(path, { cache: "no-store" }));

const post = async <T>(path: string, message: unknown): Promise<T> =>
  answer<T>(
    await fetch(path, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(message),
    }),
  );

let newest: StateMessage | null = null;

/** The newest state that the server has given: one answer may overtake another. */
async function newestState<State extends StateMessage>(asked: Promise<State>): Promise<State> {
  const state = await asked;
  if (newest === null || state.number > newest.number) newest = state;
  return newest as State;
}

const change = <State extends StateMessage = StateMessage>(path: string, message: unknown): Promise<State> =>
  newestState(post<State>(path, message));

/** The same question, whose answer never arrives where it is asked again before: one answer may overtake another. */
function ofNewest<Asked, Answer>(ask: (asked: Asked) => Promise<Answer>): (asked: Asked) => Promise<Answer> {
  let newestQuestion = 0;
  return async (asked) => {
    const question = ++newestQuestion;
    try {
      return await ask(asked);
    } finally {
      if (question !== newestQuestion) await new Promise(() => {});
    }
  };
}

async function picture(path: string): Promise<ImageBitmap> {
  const response = await fetch(path);
  if (!response.ok) throw new Refused((await response.json()).error);
  return createImageBitmap(await response.blob());
}

export const server = {
  // Lives as long as a window of this browser does, and holds a connection meanwhile: the program ends with the last
  // one. (A connection of each window's own would be one of the six that a browser opens.)
  windows: new SharedWorker("windows.js"),
  state: () => newestState(get<StateMessage>("state")),
  trial: () => get<TrialMessage>("trial"),
  edit: (edit: EditMessage) => post<StateMessage>("edit", edit),
  apply: () => change("apply", {}),
  measure: ofNewest((measures: MeasureMessage[]) => post<CourseMessage[]>("measure", { measures })),
  snap: (question: SnapQuestion) => post<SnapAnswer>("snap", question),
  naming: ofNewest((options: TrackOptions) => post<NamingMessage>("naming", options)),
  command: ofNewest((choices: Choices) => post<{ command: string }>("command", choices)),
  track: (choices: Choices) => change("track", choices),
  design: () => get<DesignMessage>("design"),
  explore: (question: ExploreQuestion) => post<ExploredMessage>("explore", question),
  save: (links: number[]) => post<{ saved: string }>("save", { links }),
  optimiseCommand: ofNewest((links: number[]) => post<{ command?: string; why_not?: string }>("optimise-command", { links })),
  optimise: (links: number[]) => change("optimise", { links }),
  stop: () => change("stop", {}),
  comparison: () => get<ComparisonMessage>("comparison"),
  study: () => get<StudyMessage>("study"),
  start: () => get<StartMessage>("start"),
  open: (path: string) => post<{ address: string }>("open", { path }),
  make: (asked: MakeQuestion) => change("make", asked),
  live: () => get<LiveMessage>("live"),
  liveView: (after: number) => post<LiveViewMessage>("view", { after }),
  livePicture: (frame: number) => picture(`picture/${frame}.jpg`),
  act: (act: LiveAct) => change<LiveStateMessage>("act", act),
  frame: (frame: number) => picture(`frame/${frame}.jpg`),
  frameOf: (trial: "human" | "exo") => (frame: number) => picture(`${trial}/${frame}.jpg`),
};
