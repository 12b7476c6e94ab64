// All that a shop's page hears: which of three pages its shopper looks at.
const words = {
  measurements: "You are entering measurements.",
  body: "You are looking at your body.",
  photos: "You are comparing photos.",
};
document.addEventListener("fitting-room-page", ({ detail }) => {
  document.querySelector("#where").textContent = words[detail.page];
});
