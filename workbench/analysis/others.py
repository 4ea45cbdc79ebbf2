"""What is asked of the controller that flies, answered of another one."""

from workbench.analysis.judging import draw_frequency, judge
from workbench.analysis.predicting import predict
from workbench.analysis.questions import AskOther, DrawFrequency, Judge
from workbench.analysis.replies import FrequencyCurves, Judged, OtherAnswered, Predicted
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working


def ask_other(subject: Subject, question: AskOther, work: Work) -> Working:
    """Answer what another controller makes of a question, on the same vehicle.

    Its models, and the machine code of its flights, are made when it is first asked about.
    """
    other, asked = subject.other(question.controller), question.question
    if isinstance(asked, Judge):
        working = judge(other, asked, work)
    elif isinstance(asked, DrawFrequency):
        working = draw_frequency(other, asked, work)
    else:
        working = predict(other, asked, work)
    for reply in working:
        if isinstance(reply, Judged | FrequencyCurves | Predicted):
            yield OtherAnswered(question, reply)
        else:
            yield None
