// The table of all tests and its filters: a search, an outcome, a suite, or a link from a line, plan or bin.

const FILTERS = {
  statement: ([n]) => {
    const [file, line] = DATA.statements[n];
    return { text: "that reach " + file + ":" + line, kept: (test) => hasBit(test.code, n) };
  },
  plan: ([n]) => {
    const [agent, label] = DATA.plans[n];
    return { text: "whose beliefs trigger plan " + label + " of " + agent, kept: (test) => hasBit(test.plans, n) };
  },
  bin: ([number, ...places]) => {
    const product = DATA.cross[number], pairs = [];
    for (let n = 0; n + 1 < places.length; n += 2) pairs.push([places[n], places[n + 1]]);
    const named = pairs.map(([n, bin]) => product.coordinates[n][0] + " " + product.coordinates[n][1][bin]).join(", ");
    const kept = (test) => product.tests[test.number].some((hit) => pairs.every(([n, bin]) => binAlong(product, hit, n) === bin));
    return { text: "that hit " + named + " of " + product.name, kept };
  },
  needed: () => ({ text: "of the smallest suite", kept: (test) => test.number in DATA.minimal.gains }),
  needless: () => ({
    text: "that add nothing to the smallest suite", kept: (test) => !(test.number in DATA.minimal.gains),
  }),
  changed: ([n]) => {
    const kinds = n === undefined ? DATA.changes : [DATA.changes[n]], numbers = new Set(kinds.flatMap((each) => each.tests));
    const which = n === undefined ? "" : ": " + kinds[0].kind;
    return { text: "that behave otherwise than in the baseline" + which, kept: (test) => numbers.has(test.number) };
  },
  verdict: ([word, n]) => ({
    text: "that " + ["passed", "failed", "did not check"][word] + " " + DATA.requirements[n],
    kept: (test) => test.verdicts[n] === "PFN"[word],
  }),
};

function testColumns() {
  const verdicts = DATA.requirements.map((name, n) => ({
    title: name, value: (test) => "FPN-".indexOf(test.verdicts[n]), cell: (test) => verdictMark(test.verdicts[n]),
    style: "mark",
  }));
  return [
    { title: "Test", value: (test) => test.id, cell: testLink, style: "wide" },
    DATA.suites.length > 1 && { title: "Suite", value: (test) => test.suite, cell: (test) => DATA.suites[test.suite], style: "less" },
    { title: "Outcome", value: (test) => test.outcome, cell: (test) => outcomeBadge(test.outcome), style: "outcome" },
    ...verdicts,
    { title: capitalized(DATA.outcomeLabel), value: (test) => test.outcomes.join(), cell: (test) => test.outcomes.join(", ") || "-", style: "less" },
    { title: "Statements", value: (test) => test.percent, cell: (test) => percent(test.percent), style: "n less" },
    { title: "Adds", value: (test) => gain(test), cell: (test) => gain(test) || "-", style: "n less" },
    { title: "Simulated", value: (test) => test.sim, cell: (test) => seconds(test.sim), style: "n less" },
  ].filter(Boolean);
}

/** The points that a test adds to the smallest suite; null if it is not in it. */
function gain(test) {
  return test.number in DATA.minimal.gains ? DATA.minimal.gains[test.number] : null;
}

function testLink(test) {
  return h("a", { class: "mono", href: "#test/" + test.anchor }, test.id);
}

function select(label, every, options, change) {
  return h("select", { "aria-label": label, onchange: change },
    h("option", { value: "" }, every), options.map(([value, text]) => h("option", { value }, text)));
}

/** The page of tests; returns the function that shows it, given the rest of the address after "tests". */
function testsPage(place) {
  if (!TESTS.length) {
    place.append(h("p", { class: "card soft" }, "No test was selected."));
    return () => {};
  }
  const table = new Table(testColumns(), TESTS);
  let filter = { kept: () => true };
  const refresh = () => { table.page = 0; table.draw(); };
  const changed = () => { keepFilters({ q: search.value, outcome: outcome.value, suite: suite.value }); refresh(); };
  const search = h("input", {
    type: "search", placeholder: "Search ids, beliefs, " + DATA.outcomeLabel, "aria-label": "Search tests", oninput: changed,
  });
  const present = [...new Set(TESTS.map((test) => test.outcome))].sort();
  const outcome = select("Outcome", "every outcome", present.map((each) => [each, DATA.outcomeWords[each]]), changed);
  const suite = select("Suite", "every suite", DATA.suites.map((name, n) => [n, name]), changed);
  suite.hidden = DATA.suites.length < 2;
  const description = h("span", {});
  const notice = h("p", { class: "notice mild", hidden: true }, description, " ", h("a", { href: "#tests" }, "show all"));
  table.kept = (test) =>
    search.value.toLowerCase().split(/\s+/).every((word) => test.text.includes(word)) &&
    (!outcome.value || test.outcome === outcome.value) &&
    (!suite.value || test.suite === Number(suite.value)) && filter.kept(test);
  place.append(h("div", { class: "filter", role: "search" }, search, outcome, suite), notice, table.element);
  return ([kind, ...numbers], filters) => {
    search.value = filters.get("q") || "";
    outcome.value = filters.get("outcome") || "";
    suite.value = filters.get("suite") || "";
    filter = kind in FILTERS ? FILTERS[kind](numbers.map(Number)) : { kept: () => true };
    notice.hidden = !filter.text;
    description.textContent = filter.text ? "Tests " + visible(filter.text) + "." : "";
    refresh();
  };
}
