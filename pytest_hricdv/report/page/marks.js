// The verdicts of a test as marks, one for each requirement: a picture of few elements, as a table has thousands of marks.

// Height and width of a mark in units of its picture; a mark is .95rem wide.
const MARK = 16, MARK_REM = 0.95;
const MARKED = {
  P: { word: "passed", path: (x) => `M${x + 3.5} 8.5l3 3.5 6-8`, style: "stroke:var(--ok)" },
  F: { word: "failed", path: (x) => `M${x + 4} 4l8 8m0-8l-8 8`, style: "stroke:var(--bad);stroke-width:2.4", ground: "var(--bad-bg)" },
  K: { word: "failed, as is known", path: (x) => `M${x + 4} 4l8 8m0-8l-8 8`, style: "stroke:var(--warn)", ground: "var(--warn-bg)" },
  N: { word: "not checked", path: (x) => `M${x + 7.5} 8h1`, style: "stroke:var(--soft);stroke-width:2.4" },
  "-": { word: "not monitored", path: () => "", style: "" },
};

function svgElement(tag, attributes, children = []) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** A picture of letters' marks, side by side. */
function marksOf(letters) {
  const places = (letter) => [...letters].flatMap((each, n) => (each === letter ? [n * MARK] : []));
  const parts = Object.entries(MARKED).filter(([letter]) => letters.includes(letter)).flatMap(([letter, { path, style, ground }]) => [
    ground && svgElement("path", { d: places(letter).map((x) => `M${x + 0.5} 0h15v${MARK}h-15z`).join(""), fill: ground }),
    svgElement("path", { d: places(letter).map(path).join(""), style }),
  ].filter(Boolean));
  return svgElement("svg", {
    class: "marks", viewBox: `0 0 ${letters.length * MARK} ${MARK}`, style: `width:${MARK_REM * letters.length}rem;height:${MARK_REM}rem`,
  }, parts);
}

// Letters -> the picture of them, to be copied: many tests have the same verdicts.
const marksMade = new Map();

/** The verdicts of a test; what each is comes up below the pointer, or at a touch. */
function verdictMarks({ verdicts }) {
  if (!marksMade.has(verdicts)) {
    const named = (letters) => DATA.requirements.filter((_, n) => letters.includes(verdicts[n]));
    const failed = named("FK"), picture = marksOf(verdicts);
    picture.setAttribute("role", "img");
    picture.setAttribute("aria-label", visible((failed.length ? "failed " + failed.join(", ") + "; " : "") + named("P").length + " passed, " + named("N").length + " not checked"));
    picture.dataset.verdicts = verdicts;
    marksMade.set(verdicts, picture);
  }
  return marksMade.get(verdicts).cloneNode(true);
}

/** The mark of a picture below a pointer: the number of its requirement, and where it is. */
function markAt(picture, event) {
  const { left, top, bottom, width } = picture.getBoundingClientRect(), count = picture.dataset.verdicts.length;
  const n = Math.min(count - 1, Math.max(0, Math.floor(((event.clientX - left) / width) * count)));
  return { n, left: left + (n * width) / count, top, bottom };
}

/** What a mark says: the requirement, the verdict, and its title. */
function markText(picture, event) {
  const { n } = markAt(picture, event), name = DATA.requirements[n];
  return [h("strong", {}, name), " " + capitalized(MARKED[picture.dataset.verdicts[n]].word), DATA.titles[name] && [h("br"), DATA.titles[name]]];
}

/** What the marks mean. */
function marksKey() {
  return ["P", "F", "K", "N"].map((letter) => [h("span", { class: "nowrap" }, marksOf(letter), " " + MARKED[letter].word), " "]);
}
