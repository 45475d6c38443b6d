#!/usr/bin/perl
# Signals: which drain, which reload; each while a job runs.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../../support", $FindBin::Bin;
use Sockets;
use Vt;

Sockets::options();
my $cloud = sphere_ply(3000);
for my $signal (qw(TERM INT QUIT USR1)) {
    my $daemon = Vt->start('drain-timeout' => 0, jobs => 1);
    my $id = $daemon->submit('points=3000&iterations=10000', $cloud);
    wait_until(sub { $daemon->status($id) eq 'running' }, 20) or die 'no job runs';
    my $status = $daemon->stop($signal);
    my $drained = $daemon->log_text =~ /"msg":"draining"/;
    my $again = Vt->start(dir => $daemon->{dir});
    my $job = $again->status($id);
    $again->stop('KILL');
    Sockets::row('F10', "SIG$signal while a job runs" . ($signal =~ /QUIT|USR1/ ? ' (before: killed)' : ''), "ends with $status, job $job after the next start",
        'ends with 0, job goes on', $status eq '0' && $drained && $job =~ /^(?:accepted|running)$/);
}
my $daemon = Vt->start;
kill 'HUP', $daemon->{pid};
my $read = wait_until(sub { $daemon->log_text =~ /"msg":"settings reloaded"/ }, 5);
my $alive = eval { $daemon->get('/livez')->{status} } // 0;
Sockets::row('F10', 'SIGHUP (before: killed)', ($read ? 'settings reloaded' : 'nothing') . ", /livez $alive", 'settings reloaded, /livez 200', $read && $alive == 200);
$daemon->stop;
