# The app in a browser, and the command line: docs/install.md says how to run it.
#   docker build -t drone-workbench .
#   docker run --rm --shm-size 1g -p 127.0.0.1:6080:6080 drone-workbench
FROM python:3.13-slim-bookworm AS wheel
COPY . /source
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /source

FROM python:3.13-slim-bookworm
RUN apt-get update \
 && apt-get install -y --no-install-recommends novnc openbox tigervnc-standalone-server \
 && rm -rf /var/lib/apt/lists/*
ENV DISPLAY=:1 \
    PYTHONUNBUFFERED=1 \
    QTWEBENGINE_DISABLE_SANDBOX=1 \
    WORKBENCH_APT=yes
COPY constraints.txt tools/apt.py tools/check_system.py tools/app_in_browser.sh /setup/
COPY --from=wheel /wheels /wheels
# Chromium's own sandbox needs rights that containers lack, and the view shows only our own page.
RUN pip install --no-cache-dir -c /setup/constraints.txt "$(echo /wheels/*.whl)[app,logs]" pytest \
 && python /setup/check_system.py \
 && rm -rf /var/lib/apt/lists/* /wheels
RUN useradd --create-home pilot
USER pilot
WORKDIR /home/pilot
EXPOSE 6080
CMD ["/setup/app_in_browser.sh"]
