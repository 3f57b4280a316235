// What a key opens anywhere: "/" one search over the whole page, whose hits are links, and "?" the list of keys.

const MOST_HITS = 40;

/** Everything that can be found: what it is called, of what kind it is, what it is found by, and where it is. */
function everything() {
  const texts = searchedTexts();
  const entry = (kind, name, hash, more) => ({ kind, name, hash, text: (name + "\n" + (more || "")).toLowerCase() });
  const links = [...document.querySelectorAll("header nav a")].map((link) => [link.hash, link.textContent]);
  const files = ["code", "plans"].flatMap((id) => [...document.getElementById(id).querySelectorAll("details.text")].flatMap((file) => {
    const name = file.dataset.title, hash = "#" + id + "/" + encodeURIComponent(name);
    const lines = [...file.querySelectorAll("tbody tr")].map((row) => entry(id === "code" ? "code" : "plan", name + ":" + row.cells[0].textContent + "  " + row.cells[2].textContent.trim(), hash));
    return [entry(id === "code" ? "file" : "agent", name, hash), ...lines];
  }));
  return [
    ...[...new Map(links)].map(([hash, name]) => entry("view", name, hash)),
    ...DATA.requirements.map((name) => entry("requirement", name + " " + (DATA.titles[name] || ""), "#requirement/" + encodeURIComponent(name))),
    ...[...document.querySelectorAll("#causes h3[id]")].map((heading) => entry("cause", heading.textContent.trim(), "#" + heading.id, heading.parentElement.textContent)),
    ...TESTS.map((test, n) => entry("test", test.id, "#test/" + test.anchor, texts[n])),
    ...[...document.querySelectorAll("#closure .hole h3")].map((heading) => entry("not covered", heading.textContent.trim(), "#closure")),
    ...files,
  ];
}

function startSearch() {
  const input = h("input", { type: "search", "aria-label": "Search everything", placeholder: "tests, requirements, causes, code, plans" });
  const hits = h("ul", { class: "hits" }), said = h("p", { class: "soft small", "aria-live": "polite" });
  const box = h("dialog", { class: "search", "aria-label": "Search" }, input, said, hits);
  let entries = null;
  const draw = () => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = words.length ? entries.filter((each) => words.every((word) => each.text.includes(word))) : [];
    // What is called so comes before what only has it somewhere.
    const named = (each) => words.every((word) => each.name.toLowerCase().includes(word));
    const sorted = [...found.filter(named), ...found.filter((each) => !named(each))];
    hits.replaceChildren(...sorted.slice(0, MOST_HITS).map((each) => h("li", {}, h("a", { href: each.hash, onclick: () => box.close() }, h("span", { class: "soft small" }, each.kind), " ", each.name))));
    said.textContent = words.length ? (found.length > MOST_HITS ? "The first " + MOST_HITS + " of " + found.length : found.length + " found") : "";
  };
  const step = (by) => {
    const links = [...hits.querySelectorAll("a")], at = links.indexOf(document.activeElement) + by;
    (at < 0 ? input : links[Math.min(at, links.length - 1)] || input).focus();
  };
  input.addEventListener("input", draw);
  box.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown" || event.key === "ArrowUp") { event.preventDefault(); step(event.key === "ArrowDown" ? 1 : -1); }
    if (event.key === "Enter" && event.target === input && hits.querySelector("a")) hits.querySelector("a").click();
  });
  document.body.append(box);
  const open = () => {
    entries = entries || everything();
    box.showModal();
    input.select();
  };
  onKey("/", open);
  document.querySelector("header.top .theme").before(h("button", { type: "button", class: "find", onclick: open, title: "Search everything (key /)" }, "Search"));
}

/** Does something at a key, unless something is being written or a dialog is open. */
function onKey(key, act) {
  document.addEventListener("keydown", (event) => {
    if (event.key !== key || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]") || event.target.closest("input, select, textarea")) return;
    event.preventDefault();
    act();
  });
}

const KEYS = [
  ["/", "search everything"], ["?", "this list"], ["n", "next failing test, or unexecuted statement"], ["p", "the one before"],
  ["← →", "in a run: previous and next event of the expanded lanes"], ["Home End", "its beginning and end"], ["v", "its next violation"], ["+ - 0", "zoom in, out, all of it; also the wheel with Ctrl or Shift, and a drag along the axis of time"],
];

function startKeys() {
  const row = ([keys, does]) => h("tr", {}, h("th", { scope: "row" }, keys.split(" ").flatMap((key) => [h("kbd", {}, key), " "])), h("td", {}, does));
  const box = h("dialog", { class: "keys", "aria-label": "Keys" }, h("table", {}, h("tbody", {}, KEYS.map(row))), h("form", { method: "dialog" }, h("button", {}, "Close")));
  document.body.append(box);
  onKey("?", () => box.showModal());
}
