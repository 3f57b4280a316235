// The table of all tests and its filters: a search, an outcome, a suite, a cause, or a link from a line, plan or bin.

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
    return { text: "that behave differently than before" + which, kept: (test) => numbers.has(test.number) };
  },
  verdict: ([word, n]) => ({
    text: "that " + ["passed", "failed", "did not check"][word] + " " + DATA.requirements[n],
    kept: (test) => ["P", "FK", "N"][word].includes(test.verdicts[n]),
  }),
};

// So many characters of a requirement's name fit upright into the head of the table.
const MOST_HEAD = 14;

function testColumns() {
  const verdicts = DATA.requirements.map((name, n) => ({
    key: name, title: name, head: shortened(name, MOST_HEAD), note: name + (DATA.titles[name] ? " " + DATA.titles[name] : ""), value: (test) => "FKPN-".indexOf(test.verdicts[n]),
  }));
  return [
    { key: "test", title: "Test", value: (test) => test.id, cell: testIdLink, style: "id" },
    DATA.suites.length > 1 && { key: "suite", title: "Suite", value: (test) => test.suite, cell: (test) => DATA.suites[test.suite], style: "less" },
    { key: "outcome", title: "Outcome", value: (test) => test.outcome, cell: (test) => outcomeBadge(test.outcome), style: "outcome" },
    verdicts.length > 0 && { key: "requirements", title: "Requirements", parts: verdicts, cell: verdictMarks },
    TESTS.some((test) => test.outcomes.length) && { key: "ended", title: capitalized(DATA.outcomeLabel), value: (test) => test.outcomes.join(), cell: (test) => test.outcomes.join(", ") || "-", style: "some" },
    TESTS.some((test) => test.percent !== null) && { key: "statements", title: "Statements", value: (test) => test.percent, cell: (test) => percent(test.percent), style: "n" },
    { key: "adds", title: "Adds", note: "Points that it adds to the smallest suite", value: (test) => gain(test), cell: (test) => gain(test) || "-", style: "n" },
    { key: "simulated", title: "Simulated", value: (test) => test.sim, cell: (test) => seconds(test.sim), style: "n" },
    TESTS.some((test) => test.beliefs) && { key: "beliefs", title: "Beliefs", value: (test) => test.beliefs, cell: (test) => test.beliefs || "-", style: "rest" },
  ].filter(Boolean);
}

/** The points that a test adds to the smallest suite; null if it is not in it. */
function gain(test) {
  return test.number in DATA.minimal.gains ? DATA.minimal.gains[test.number] : null;
}

function testLink(test) {
  return h("a", { class: "mono", href: "#test/" + test.anchor, title: test.id }, test.id);
}

// The end of an id, `-0060eeeb`, tells it from others of its suite: where an id is cut, its end stays.
const ID_END = 9;

/** A link to a test for a narrow column, which cuts the id before its end. */
function testIdLink(test) {
  const link = testLink(test), id = visible(test.id), end = id.length - ID_END;
  if (end > 0) link.replaceChildren(h("span", { class: "cut-start" }, id.slice(0, end)), id.slice(end));
  link.setAttribute("aria-label", id); // of parts that stand side by side, it would have a blank in between
  return link;
}

function select(label, every, options, change) {
  return h("select", { "aria-label": label, onchange: change },
    h("option", { value: "" }, every), options.map(([value, text]) => h("option", { value }, text)));
}

/** The choice of an order, for the keyboard: names of requirements in the head are not reached by it one by one. */
function orderChoice(columns, table, changed) {
  const each = columns.flatMap((column) => column.parts || [column]);
  const choice = select("Order", "as they ran", each.map(({ key, title }) => [key, title]), () => {
    table.order = choice.value ? [choice.value, false] : null;
    changed();
  });
  return choice;
}

/** The page of tests; returns the function that shows it, given the rest of the address after "tests". */
function testsPage(place) {
  if (!TESTS.length) {
    place.append(h("p", { class: "card soft" }, "No test was selected."));
    return () => {};
  }
  const columns = testColumns(), table = new Table(columns, TESTS, "Tests");
  let filter = { kept: () => true }, texts = null, linked = "", drawnFor = null;
  const chosen = () => ({
    q: search.value, outcome: outcome.value, suite: suite.value, cause: cause.value,
    order: table.order ? (table.order[1] ? "-" : "") + table.order[0] : "",
  });
  // What is drawn already is not drawn again: a click on a heading changes the address, and the address shows the table.
  const draw = () => {
    const wanted = JSON.stringify([linked, chosen()]);
    if (wanted === drawnFor) table.toTop();
    else table.draw();
    drawnFor = wanted;
  };
  const changed = () => { keepFilters(chosen()); draw(); };
  const search = h("input", {
    type: "search", placeholder: "Search ids, actions, beliefs, requirements, causes, " + DATA.outcomeLabel, "aria-label": "Search tests", oninput: () => changed(),
  });
  const present = [...new Set(TESTS.map((test) => test.outcome))].sort();
  const outcome = select("Outcome", "every outcome", present.map((each) => [each, DATA.outcomeWords[each]]), () => changed());
  const suite = select("Suite", "every suite", DATA.suites.map((name, n) => [n, name]), () => changed());
  const cause = select("Cause", "every cause", DATA.failedFor.map(({ title }, n) => [n + 1, title]), () => changed());
  const order = orderChoice(columns, table, () => changed());
  suite.hidden = DATA.suites.length < 2;
  cause.hidden = !DATA.failedFor.length;
  table.sorted = () => { order.value = table.order[0]; changed(); };
  const description = h("span", {});
  const notice = h("p", { class: "notice mild", hidden: true }, description, " ", h("a", { href: "#tests" }, "show all"));
  table.kept = (test) => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    if (words.length && !texts) texts = searchedTexts();
    return words.every((word) => texts[test.number].includes(word)) &&
      (!outcome.value || test.outcome === outcome.value) &&
      (!suite.value || test.suite === Number(suite.value)) &&
      (!cause.value || DATA.failedFor[cause.value - 1].tests.includes(test.number)) && filter.kept(test);
  };
  const bar = h("div", { class: "filter", role: "search" }, search, outcome, suite, cause, h("label", { class: "small soft" }, "Order ", order));
  const key = h("p", { class: "small soft marks-key" }, DATA.requirements.length > 0 && marksKey());
  place.append(bar, notice, table.element, key);
  tipOver(table.body, ".marks", markText, markAt);
  return ([kind, ...numbers], filters) => {
    search.value = filters.get("q") || "";
    for (const [name, choice] of Object.entries({ outcome, suite, cause })) choice.value = filters.get(name) || "";
    const by = filters.get("order") || "";
    table.order = by ? [by.replace(/^-/, ""), by.startsWith("-")] : null;
    order.value = table.order ? table.order[0] : "";
    linked = [kind, ...numbers].join("/");
    filter = kind in FILTERS ? FILTERS[kind](numbers.map(Number)) : { kept: () => true };
    notice.hidden = !filter.text;
    description.textContent = filter.text ? "Tests " + visible(filter.text) + "." : "";
    draw();
  };
}
