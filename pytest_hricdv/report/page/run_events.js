// What happened in a run, event by event, and what held at a time.

/** Events [{time, lane, text, failed}] in the order of time. */
function runEvents(made, failures) {
  const events = made.dots.map((dot) => ({ time: dot.time, lane: dot.lane, text: dot.event, failed: false }));
  for (const bar of made.bars) {
    if (bar.event) events.push({ time: bar.from, lane: bar.lane, text: bar.event, failed: false });
    if (bar.ended) events.push({ time: bar.to, lane: bar.lane, text: bar.ended, failed: Boolean(bar.failed) });
  }
  const decided = new Set(events.filter((event) => event.failed).map((event) => event.lane + "\t" + event.time));
  for (const { name, time } of failures) {
    if (!decided.has(name + "\t" + time)) events.push({ time, lane: name, text: name + " violated", failed: true });
  }
  return events.sort((a, b) => a.time - b.time || Number(b.failed) - Number(a.failed));
}

/** The signals that are drawn as curves, each with its points. */
function curvesOf(timeline) {
  return Object.entries(timeline.signals).map(([name, text]) => ({ name, points: parsedSignal(text, timeline.end_s) }))
    .filter(({ name, points }) => !isSwitch(name, points))
    .map(({ name, points }) => ({ name, points: withGaps(points, name, timeline) }));
}

const failedVerdicts = (found) => found.verdicts.filter((verdict) => verdict.verdict === "Failed");

const textsOf = (name) => DATA.texts[DATA.requirements.indexOf(name)] ?? { title: "", formula: "", reads: [], limits: [] };

/** The names that matter to what failed: null where all do, as nothing failed or nobody knows what it reads. */
function mattering(found) {
  const failed = failedVerdicts(found), reads = failed.map((verdict) => textsOf(verdict.name).reads);
  if (!failed.length || reads.some((names) => !names.length)) return null;
  const names = new Set(failed.map((verdict) => verdict.name));
  for (const name of reads.flat()) names.add(name).add(name.split(".")[0]);
  return names;
}

/** Whether a lane is open at first: those of what failed and what it reads, and of who acts. */
function opensFirst(lane, kind, names) {
  return !names || names.has(lane) || ["state", "actor", "disturbance", "node"].includes(kind);
}

/** Limits [{text, value}] that requirements compare a signal with: of what failed, or else all that are in sight. */
function limitsOf(signal, points, found) {
  const values = points.flatMap(([, value]) => (value === null ? [] : [value])), someFailed = failedVerdicts(found).length > 0;
  const low = Math.min(...values), high = Math.max(...values), room = (high - low) / 2;
  const owners = new Map();
  for (const { name, verdict } of found.verdicts) {
    for (const [read, relation, value] of textsOf(name).limits) {
      if (read !== signal || (verdict !== "Failed" && (someFailed || value < low - room || value > high + room))) continue;
      const key = relation + " " + value;
      if (!owners.has(key)) owners.set(key, { value, relation, names: [] });
      if (!owners.get(key).names.includes(name)) owners.get(key).names.push(name);
    }
  }
  return [...owners.values()].map(({ value, relation, names }) => ({
    value, text: (names.length > 3 ? names.slice(0, 3).join(", ") + ", …" : names.join(", ")) + ": " + relation + " " + value,
  }));
}

/** The last of ascending [time, value] pairs that is not after a time. */
function valueAt(points, time) {
  let low = 0, high = points.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (points[middle][0] <= time) low = middle + 1;
    else high = middle;
  }
  return low ? points[low - 1][1] : null;
}

/** What a bar's lane shows at a time: the label of the state or text, or whether a switch is on. */
function barAt(made, lane, time) {
  return made.bars.findLast((bar) => bar.lane === lane && bar.from <= time && time < bar.to);
}

/** How a requirement stands at a time, in words. `violated`: when it was violated first; undefined where it was not. */
function verdictAt(made, name, violated, time) {
  if (violated <= time) return { text: "failed at " + seconds(violated), failed: true };
  const bars = made.bars.filter((bar) => bar.lane === name && bar.from <= time), open = bars.find((bar) => time < bar.to);
  if (open) return { text: "triggered at " + seconds(open.from) + ", not decided yet", failed: false };
  return { text: bars.length ? "passed so far" : "not triggered yet", failed: false };
}
