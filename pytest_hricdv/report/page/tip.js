// A note that comes up below the pointer, at a touch, or at the keyboard's place, and goes with it.

const tip = h("div", { class: "tip", role: "status", hidden: true });
document.body.append(tip);
let tipOf = null; // the place whose note it is: another one does not take it away

/** Shows `text(element, event)` over elements of a place that match a selector, beside `placeOf(element, event)`, where this says so. */
function tipOver(place, selector, text, placeOf, isShown = () => true) {
  const show = (event) => {
    const over = event.target.closest(selector), element = over && isShown(over) ? over : null;
    if (!element && tipOf === place) tip.hidden = true;
    if (!element) return;
    tipOf = place;
    tip.hidden = false;
    tip.replaceChildren(...[text(element, event)].flat(Infinity).filter((part) => part !== null && part !== undefined && part !== false));
    const at = placeOf(element, event);
    tip.style.left = Math.max(4, Math.min(at.left, innerWidth - tip.offsetWidth - 8)) + "px";
    tip.style.top = (at.bottom + tip.offsetHeight + 8 > innerHeight ? at.top - tip.offsetHeight - 4 : at.bottom + 4) + "px";
  };
  place.addEventListener("pointermove", show);
  place.addEventListener("click", show);
  place.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse" && tipOf === place) tip.hidden = true; });
  document.addEventListener("pointerdown", (event) => { if (!event.target.closest(selector)) tip.hidden = true; });
}

addEventListener("scroll", () => { tip.hidden = true; }, { capture: true, passive: true });
addEventListener("keydown", (event) => { if (event.key === "Escape") tip.hidden = true; });
