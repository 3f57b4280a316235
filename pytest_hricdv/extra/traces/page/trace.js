// The MCAP files of a test's run.

function traceView(trace) {
  return section("Trace", trace.file && h("p", {}, h("a", { href: trace.file }, trace.file), " (MCAP, for Foxglove and other viewers)"),
    trace.bag && h("p", {}, h("a", { href: trace.bag }, trace.bag), " (the messages of ROS 2, for ros2 bag)"),
    trace.note && h("p", { class: "soft" }, trace.note));
}

TEST_SECTIONS.first.push((found) => found.trace && traceView(found.trace));
