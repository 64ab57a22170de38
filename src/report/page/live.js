// Updates a served page: polls the state of the results every second and loads the new content when it changes. Camera,
// grasp, frame, colours and chart selections are kept.
const live = byId("live");

function tell(text, goes) {
  live.hidden = false;
  if (live.textContent !== text) live.textContent = text;
  live.classList.toggle("goes", goes);
}

const ask = async (path) => {
  const answer = await fetch(path, { cache: "no-store" });
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer;
};

// Settings of the reader in the sections: quantity of each chart, and unfolded tables, by title.
const charts = () => [...document.querySelectorAll("[data-chart]")].map((figure) => [figure.dataset.title, figure.querySelector("select")]);
const folds = () => [...document.querySelectorAll("details")].map((fold) => [fold.querySelector("summary").textContent, fold]);

function renew(page) {
  const chosen = new Map(charts().map(([title, choice]) => [title, choice.value]));
  const open = new Set(folds().filter(([, fold]) => fold.open).map(([title]) => title));
  data = dataOf(page);
  byId("origins").replaceWith(page.getElementById("origins"));
  meshes.clear();
  const pads = byId("viewer") || page.getElementById("viewer");
  page.getElementById("viewer")?.remove();
  document.querySelectorAll("main > section:not(#viewer)").forEach((section) => section.remove());
  if (pads && !pads.isConnected) document.querySelector("main").prepend(pads);
  document.querySelector("main").append(...page.querySelectorAll("main > section"));
  drawCharts();
  for (const [title, choice] of charts())
    if (chosen.has(title) && choice.value !== chosen.get(title)) {
      choice.value = chosen.get(title);
      choice.dispatchEvent(new Event("change"));
    }
  for (const [title, fold] of folds()) fold.open = open.has(title);
  if (controls) controls.refresh();
  else if (pads) start();
}

async function follow() {
  try {
    const { state } = await (await ask("state")).json();
    if (state !== data.state) renew(new DOMParser().parseFromString(await (await ask(".")).text(), "text/html"));
    tell("live", true);
  } catch (error) {
    tell(error instanceof TypeError ? "the viewer has ended" : error.message, false);
  }
  setTimeout(follow, 1000);
}
if (data.state !== null) follow();
