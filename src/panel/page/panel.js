fetch("api/v1/drives").then((answer) => answer.text()).then((text) => {
  document.getElementById("state").textContent = text;
});
