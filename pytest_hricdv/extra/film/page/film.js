// The film of a failed test, and its key frames.

function filmView(film) {
  const moving = film.video && (film.video.endsWith(".gif")
    ? h("img", { class: "film", src: film.video, alt: "Film of the run", loading: "lazy" })
    : h("video", { class: "film", src: film.video, controls: true, preload: "none" }));
  const strip = film.strip && h("a", { href: film.strip },
    h("img", { class: "film", src: film.strip, alt: "Key frames of the run", loading: "lazy" }));
  return section("Film", strip, moving, film.note && h("p", { class: "soft" }, film.note));
}

TEST_SECTIONS.first.push((found) => found.film && filmView(found.film));
