// A study: its report, its steps with their state, and one of them run again.
import { attempt, button, copyText, onClick, part, say, sayWhy, showJob } from "./dom";
import { StateMessage, StepMessage, StudyMessage } from "./messages";
import { server } from "./server";
import { TEXTS } from "./texts";

export class StudyPage {
  private running: string | null = null; // step that is under way; empty: all

  constructor(private study: StudyMessage) {
    part("study").hidden = false;
    part("name").textContent = study.name;
    document.title = `${study.name} – lake review`;
    part("no-report").textContent = TEXTS.noReport;
    part("study-command").textContent = study.command;
    part("report-file").textContent = TEXTS.reportFile(study.report);
    onClick("run-all", () => void this.run(""));
    onClick("study-stop", () => void server.stop().catch(sayWhy));
    onClick("study-copy", () => void copyText("study-command"));
    this.show();
    this.showReport();
  }

  update(state: StateMessage): void {
    const { running, failed } = state.job!, step = state.step ?? "", was = this.running;
    showJob("study", state.job!, TEXTS.running(step));
    this.running = running ? step : null;
    if (was === this.running) return;
    this.show();
    if (running) return;
    if (failed) say(TEXTS.stepFailed(step, failed), true);
    else say(TEXTS.ran(step));
    void this.refresh();
  }

  private refresh(): Promise<void> {
    return attempt(async () => {
      this.study = await server.study();
      this.show();
      this.showReport();
    });
  }

  private run(step: string): Promise<void> {
    return attempt(async () => this.update(await server.runStep(step)));
  }

  private show(): void {
    const { steps } = this.study, due = steps.filter((step) => step.due !== null);
    part("state").textContent = TEXTS.studyState(due.length, steps.length);
    part("steps").replaceChildren(...steps.map((step) => this.stepLine(step)));
    part<HTMLButtonElement>("run-all").disabled = this.running !== null || due.length === 0;
  }

  private stepLine(step: StepMessage): HTMLElement {
    const line = document.createElement("li"), name = document.createElement("b"), detail = document.createElement("small");
    const link = document.createElement("a");
    const waits = step.after.filter((other) => this.study.steps.some(({ name, due }) => name === other && due !== null));
    link.textContent = step.name;
    link.href = step.name === "report" ? "results/report.html" : `results/${step.name}/`;
    link.target = "_blank";
    name.append(step.due === "not made yet" ? step.name : link);
    detail.textContent = `${step.what}; ${step.due === null ? TEXTS.upToDate : TEXTS.due(step.due)}`;
    line.classList.toggle("due", step.due !== null);
    line.classList.toggle("running", this.running === step.name);
    line.dataset.step = step.name;
    line.append(name, detail);
    if (step.due === null) return line;
    const run = button(TEXTS.runStep, () => void this.run(step.name));
    run.disabled = this.running !== null || waits.length > 0;
    if (waits.length > 0) run.title = TEXTS.waits(waits);
    line.append(run);
    return line;
  }

  private showReport(): void {
    const frame = part<HTMLIFrameElement>("report");
    frame.hidden = !this.study.has_report;
    part("no-report").hidden = this.study.has_report;
    if (this.study.has_report) frame.src = `report?${Date.now()}`;
  }
}
