// What is to be seen of two things that lie over each other.
for (const box of document.querySelectorAll("[data-shows]")) {
  box.addEventListener("change", () => {
    const style = box.dataset.shows;
    for (const e of document.querySelectorAll(`.pictures .${style}, .pictures .${style}-text`)) {
      e.style.display = box.checked ? "" : "none";
    }
  });
}
