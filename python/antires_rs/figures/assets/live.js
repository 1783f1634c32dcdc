// Unpacks and draws the figures of this page; without it, or where it fails, the pictures stay.
(function () {
  "use strict";
  if (!window.DecompressionStream || !window.IntersectionObserver) return;
  async function unpacked(element) {
    const bytes = Uint8Array.from(atob(element.textContent.trim()), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }
  let ready = null;
  function library() {
    ready = ready || unpacked(document.getElementById("library")).then((text) => {
      const script = document.createElement("script");
      script.textContent = text;
      document.head.appendChild(script);
      window.Bokeh.set_log_level("warn");
    });
    return ready;
  }
  async function draw(figure) {
    try {
      const item = JSON.parse(await unpacked(figure.querySelector(".packed")));
      const place = figure.querySelector(".live");
      if (!item.scene) await library();
      figure.classList.add("shown");
      if (item.scene) window.drawScene(place, item);
      else await window.Bokeh.embed.embed_item(item, place.id);
      figure.classList.add("drawn");
    } catch (error) {
      figure.classList.remove("shown");
      console.error(error);
    }
  }
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      seen.unobserve(entry.target);
      draw(entry.target);
    }
  }, { rootMargin: "400px" });
  for (const packed of document.querySelectorAll("figure .packed")) seen.observe(packed.parentElement);
})();
