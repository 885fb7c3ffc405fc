// Parts of the page by their id.
import { JobMessage } from "./messages";
import { server } from "./server";
import { TEXTS } from "./texts";

export function part<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no part '${id}'`);
  return found as T;
}

export const onClick = (id: string, action: () => void) => part(id).addEventListener("click", action);

/** A button, named by text only: names come from files. */
export function button(text: string, action: () => void): HTMLButtonElement {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.addEventListener("click", action);
  return made;
}

/** An entry of a list, by text only too. */
export function item(text: string): HTMLLIElement {
  const made = document.createElement("li");
  made.textContent = text;
  return made;
}

/** What has just been done or cannot be, also for those who do not see it. */
export function say(text: string, isError = false): void {
  const line = part("said");
  line.textContent = text;
  line.classList.toggle("error", isError);
}

export function sayWhy(why: unknown): void {
  say(why instanceof Error ? why.message : String(why), true);
}

/** Does this, or says why it cannot be done. */
export async function attempt(work: () => Promise<void>): Promise<void> {
  try {
    await work();
  } catch (why) {
    sayWhy(why);
  }
}

/** Whether the control that has the focus does something of its own with this key: then it is no command of the page. */
export function isOfControl(event: KeyboardEvent): boolean {
  const { target, key } = event;
  if (target instanceof HTMLSelectElement) return true;
  if (target instanceof HTMLInputElement && target.type !== "range") return true;
  const isPress = key === "Enter" || key === " ";
  if (target instanceof HTMLButtonElement || target instanceof HTMLAnchorElement) return isPress;
  if (target instanceof HTMLElement && target.tagName === "SUMMARY") return isPress;
  const moves = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown"];
  return target instanceof HTMLInputElement && moves.includes(key) && !event.altKey;
}

/** Keys of the whole page: what is given for one is done, and the browser does nothing else with it. */
export function onKey(actionOf: (event: KeyboardEvent) => (() => void) | null): void {
  document.addEventListener("keydown", (event) => {
    const action = actionOf(event);
    if (!action) return;
    event.preventDefault();
    action();
  });
}

/** 1 to undo, -1 to redo, 0 for another key. */
export function undoOf(event: KeyboardEvent): 1 | -1 | 0 {
  if (!event.ctrlKey && !event.metaKey) return 0;
  const key = event.key.toLowerCase();
  if (key === "z" && !event.shiftKey) return 1;
  return key === "y" || key === "z" ? -1 : 0;
}

/** A program's own line, "tracking: 120/1010 frames, …", as a bar. */
export function showProgress(bar: HTMLProgressElement, line: string): void {
  const numbers = /(\d+)\/(\d+)/.exec(line);
  if (numbers) bar.value = Number(numbers[1]) / Number(numbers[2]);
  else bar.removeAttribute("value");
}

/** Long work: its bar and its Stop button, whose ids begin alike, and how far it is. */
export function showJob(id: string, { running, progress }: JobMessage, doing: string): void {
  const bar = part<HTMLProgressElement>(`${id}-progress`);
  bar.hidden = part(`${id}-stop`).hidden = !running;
  if (!running) return;
  showProgress(bar, progress);
  say(progress || doing);
}

/** To the clipboard. */
export function copy(text: string): Promise<void> {
  return attempt(async () => {
    await navigator.clipboard.writeText(text);
    say(TEXTS.copied);
  });
}

export const copyText = (id: string) => copy(part(id).textContent ?? "");

/** As a file that the browser downloads. */
export function save(text: string, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

/** The page of a film or of results, in a window that is opened at once, as browsers forbid it later. */
export async function openPage(path: string): Promise<void> {
  const page = window.open("about:blank");
  try {
    const { address } = await server.open(path);
    if (page) page.location.href = address;
    else location.href = address;
  } catch (why) {
    page?.close();
    sayWhy(why);
  }
}
