// Addresses: what stands after "#" is a view, what is shown of it, and filters: "tests/verdict/1/3?q=leg4&outcome=failed".

/** The parts of the address: `path` (the view first), and `filters` by name. */
function addressed() {
  const [path, query] = location.hash.slice(1).split("?", 2);
  return { path, parts: path.split("/"), filters: new URLSearchParams(query || "") };
}

/** Puts filters into the address, without a step of the browser's history; empty ones are left out. */
function keepFilters(filters) {
  const query = new URLSearchParams(Object.entries(filters).filter(([, value]) => value !== "")).toString();
  history.replaceState(history.state, "", "#" + addressed().path + (query ? "?" + query : ""));
  places.at = location.hash;
}

// Where the browser's history was left: the place that a view was scrolled to goes with its entry.
const places = { at: null, waits: 0, shown: 0, fills: false };

/** The boxes of the view in sight that scroll by themselves. */
function boxes() {
  return [...document.querySelectorAll(".view:not([hidden]) .rows")];
}

function keepPlace() {
  if (location.hash === places.at && !places.fills) history.replaceState({ y: scrollY, boxes: boxes().map((box) => box.scrollTop) }, "");
}

function watchPlaces() {
  history.scrollRestoration = "manual";
  addEventListener("click", keepPlace, true);
  addEventListener("scroll", () => {
    // Browsers allow few changes of the history a second.
    clearTimeout(places.waits);
    places.waits = setTimeout(keepPlace, 150);
  }, { passive: true, capture: true });
}

/** Scrolls to where an entry of the history was left; false where it is a new one. */
function backAtPlace(kept) {
  if (!kept || typeof kept.y !== "number") return false;
  scrollTo(0, kept.y);
  boxes().forEach((box, n) => {
    box.scrollTop = kept.boxes[n] || 0;
    box.dispatchEvent(new Event("scroll"));
  });
  return true;
}
