// The film of a failed test, which follows the cursor of its run and moves it, and its key frames.

/** Whether the browser can be asked for a frame of it: a GIF cannot be, and older reports have no times of frames. */
const followsCursor = (film) => Boolean(film && film.video && !film.video.endsWith(".gif") && film.times_s && film.times_s.length);

/** The film beside the lanes, at the cursor. */
function filmPanel({ film }, run) {
  if (!followsCursor(film)) return null;
  const { times_s: times } = film, perSecond = film.frames / film.seconds;
  const moving = h("video", { class: "film beside", src: film.video, controls: true, muted: true, preload: "auto", "aria-label": "Film of the run, at the cursor" });
  const said = h("p", { class: "soft small", hidden: true }, "This browser cannot play the film; its key frames are below.");
  moving.addEventListener("error", () => { said.hidden = false; moving.hidden = true; });
  const frameAt = () => Math.min(times.length - 1, Math.floor(moving.currentTime * perSecond));
  moving.addEventListener("timeupdate", () => {
    if (!moving.paused) run.window.move(times[frameAt()], "film");
  });
  const at = (time, by) => {
    if (by === "film") return;
    const next = times.findIndex((shown) => shown > time + 5e-4), frame = Math.max(0, (next < 0 ? times.length : next) - 1);
    // The middle of a frame: at its edge a browser may show the one before.
    if (frame !== frameAt()) moving.currentTime = (frame + 0.5) / perSecond;
  };
  return { element: h("div", {}, moving, said), at, isFirst: true };
}

function filmView(film) {
  const moving = film.video && !followsCursor(film) && (film.video.endsWith(".gif")
    ? h("img", { class: "film", src: film.video, alt: "Film of the run", loading: "lazy" })
    : h("video", { class: "film", src: film.video, controls: true, preload: "none" }));
  const strip = film.strip && h("a", { href: film.strip },
    h("img", { class: "film", src: film.strip, alt: "Key frames of the run", loading: "lazy" }));
  return section(followsCursor(film) ? "Key frames of the film" : "Film", strip, moving, film.note && h("p", { class: "soft" }, film.note));
}

RUN_PANELS.push(filmPanel);
TEST_SECTIONS.first.push((found) => found.film && filmView(found.film));
