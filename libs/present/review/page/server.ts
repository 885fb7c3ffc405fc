// Questions to the server that served this page; addresses are relative, so the token stays in them.
import {
  Choices, EditMessage, NamingMessage, SnapAnswer, SnapQuestion, StateMessage, TrackOptions, TrialMessage,
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

const newWindow = () => crypto.getRandomValues(new Uint32Array(2)).join("-");
let thisWindow = newWindow();

export const server = {
  state: () => get<StateMessage>(`state?window=${thisWindow}`),
  trial: () => get<TrialMessage>("trial"),
  edit: (edit: EditMessage) => post<StateMessage>("edit", edit),
  snap: (question: SnapQuestion) => post<SnapAnswer>("snap", question),
  naming: (options: TrackOptions) => post<NamingMessage>("naming", options),
  command: (choices: Choices) => post<{ command: string }>("command", choices),
  track: (choices: Choices) => post<StateMessage>("track", choices),
  frame: async (frame: number): Promise<ImageBitmap> => {
    const response = await fetch(`frame/${frame}.jpg`);
    if (!response.ok) throw new Refused((await response.json()).error);
    return createImageBitmap(await response.blob());
  },
};

// The program ends with its last window.
window.addEventListener("pagehide", () => {
  navigator.sendBeacon("closed", new Blob([JSON.stringify({ window: thisWindow })], { type: "application/json" }));
  thisWindow = newWindow();
});
