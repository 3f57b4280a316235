// Which window of a run's time is shown, and where its cursor is.

// Seconds before and after a violation that are shown first: what led to it, and what came of it.
const AROUND_S = 10;
// A window may be as narrow as this (s): finer than a period of any control loop.
const NARROWEST_S = 0.02;

class RunWindow {
  constructor(end) {
    this.end = Math.max(end, NARROWEST_S);
    this.shown = [0, this.end];
    this.time = 0;
    this.moved = [];
    this.zoomed = [];
  }

  /** Shows the time from one to another, as far as the run has it. */
  show(begin, end) {
    const width = Math.min(Math.max(end - begin, NARROWEST_S), this.end), from = Math.min(Math.max(0, begin), this.end - width);
    this.shown = [from, from + width];
    this.zoomed.forEach((call) => call());
  }

  around(time) {
    this.show(time - AROUND_S, time + AROUND_S);
  }

  /** Widens or narrows the window around a time, which stays where it is. */
  zoom(factor, time = this.time) {
    const [begin, end] = this.shown, at = time < begin || time > end ? (begin + end) / 2 : time;
    this.show(at - (at - begin) * factor, at + (end - at) * factor);
  }

  /** Puts the cursor at a time; the window follows. `by`: what moved it. */
  move(time, by = "") {
    this.time = Math.min(Math.max(0, time), this.end);
    const [begin, end] = this.shown;
    if (this.time < begin || this.time > end) this.show(this.time - (end - begin) / 2, this.time + (end - begin) / 2);
    this.moved.forEach((call) => call(by));
  }
}
