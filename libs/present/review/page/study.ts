// A study: its report, and what it was made of, each on a page of its own.
import { button, copyText, onClick, openPage, part } from "./dom";
import { StudyMessage } from "./messages";
import { TEXTS } from "./texts";

export function showStudy({ name, command, report, has_report, parts }: StudyMessage): void {
  part("study").hidden = false;
  part("name").textContent = name;
  part("state").textContent = has_report ? "" : TEXTS.noReport;
  document.title = `${name} – lake review`;
  part("study-parts").replaceChildren(...parts.map(({ step, path }) => {
    const made = button(TEXTS.studyPart[step], () => void openPage(path));
    made.dataset.step = step;
    return made;
  }));
  part("study-command").textContent = command;
  onClick("study-copy", () => void copyText("study-command"));
  part("report-file").textContent = TEXTS.reportFile(report);
  const frame = part<HTMLIFrameElement>("report");
  frame.hidden = !has_report;
  if (has_report) frame.src = "report";
}
