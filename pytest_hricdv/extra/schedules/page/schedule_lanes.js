// A lane for each thread of the code, in the run of a test with a schedule: where it goes on, and where it is held up.

RUN_LANES.push(({ nodes = [] }, made) => {
  for (const { node, switches = [], held = [] } of nodes) {
    made.add(node, "node");
    for (const [from, to, place] of held) {
      const text = node + " waits before " + place;
      made.bars.push({ lane: node, from, to: Math.max(to, from + 1e-3), fill: "var(--c1)", event: text, ended: node + " goes on", tooltip: text + "\n" + seconds(from) + " to " + seconds(to) });
    }
    for (const [time, place] of switches) {
      const text = node + " goes on at " + place;
      made.dots.push({ lane: node, time, symbol: "circle", fill: "var(--c0)", event: text, tooltip: seconds(time) + ": " + text });
    }
  }
});
