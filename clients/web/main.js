document.body.textContent = "glint";
