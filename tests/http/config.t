#!/usr/bin/perl
# Where settings come from: flags, variables, files that variables name, the file of settings; and what is said of wrong ones.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $dir = tempdir(CLEANUP => 1);
my $count = 0;

# A file with that text; its path.
sub file {
    my ($text) = @_;
    my $path = "$dir/" . ++$count . '.conf';
    spew($path, $text);
    return $path;
}

sub check { return Vt::run('--data', "$dir/data", '--check-config', @_) }

my ($status, $text, $printed) = check();
is $status, 0, '--check-config ends well where nothing is wrong';
is $printed, "voronoid: the settings are valid\n", 'and says so';
ok !-e "$dir/data", 'without making a folder';
($status, $text) = check('--queue', 0);
is $status, 2, 'and with 2 where something is';
like $text, qr/^voronoid: --queue is "0", want a whole number from 1 to 100000$/, 'which is named';

my $sound = file("# a comment\n\n; another\nqueue = 7\n  jobs=3  \r\ntrusted-proxy = 10.0.0.1\ntrusted-proxy = 10.0.0.2\n"
        . "no-auth = 1\nlisten = 0.0.0.0:0\n");
is((check('--config', $sound))[0], 0, 'a file with comments, blanks, a list on two lines');

for my $case (
    ["queue = 0\n", qr/^voronoid: FILE line 1: --queue is "0", want a whole number from 1 to 100000$/],
    ["\njobs = 2\nheartbeat = soon\n", qr/FILE line 3: --heartbeat is "soon", want seconds from 0\.1 to 3600/],
    ["log-level = loud\n", qr/FILE line 1: --log-level is "loud", want one of debug info warn error off/],
    ["\n\nlisten = 0.0.0.0:1\n", qr/FILE line 3: with --listen 0\.0\.0\.0:1 the daemon is open to other machines/],
    ["trusted-proxy = 10.0.0.1\ntrusted-proxy = proxy\n", qr/FILE line 2: --trusted-proxy holds "proxy"/],
    ["colour = red\n", qr/FILE line 1: no setting "colour"/], ["queue\n", qr/FILE line 1: "queue" is not of the form name = value/],
    ["= 3\n", qr/FILE line 1: "= 3" is not of the form name = value/], ["config = x\n", qr/FILE line 1: no setting "config"/],
    ["queue = 1\nqueue = 2\n", qr/FILE line 2: queue is set twice, first on line 1/],
    ["queue = 1\x01\n", qr/FILE line 1: the line has a control character/], ["queue\0 = 1\n", qr/FILE line 1: the line has a NUL byte/],
    ["data = /" . 'x' x 3000 . "\n", qr/FILE line 1: .*more than 2046 bytes/],
    ["data = /" . 'x' x 1500 . "\n", qr/FILE line 1: --data has 1501 bytes, want at most 1023/],
) {
    my ($content, $message) = @$case;
    my $path = file($content);
    my ($failed, $said) = Vt::run('--check-config', '--config', $path);
    is $failed, 2, (substr($content, 0, 30) =~ tr/\n\r\0\x01/ /r) . ': refused';
    like $said =~ s/\Q$path\E/FILE/r, $message, 'by file, line, setting and range';
    is scalar(split /\n/, $said), 1, 'in one line';
}

# Everything that is wrong is told at once, in the order of reading; what follows from a fault is not.
my $faulty = file("queue = 0\njobz = 2\nkeep-inputs = 8Q\nqueue\nlisten = nowhere\nlog-level = loud\npublic-url = x\n");
{
    local $ENV{VORONOID_STREAMS} = 'many';
    ($status, $text) = check('--config', $faulty, '--heartbeat', 'soon', '--threads=1.5');
}
is $status, 2, 'a file of seven faults, a variable and two flags are refused';
is_deeply [map {s/^voronoid: (?:\Q$faulty\E )?//r} split /\n/, $text], [
    '--heartbeat is "soon", want seconds from 0.1 to 3600', '--threads is "1.5", want a whole number from 0 to 256',
    '--streams is "many", want a whole number from 1 to 100000', 'line 1: --queue is "0", want a whole number from 1 to 100000',
    'line 2: no setting "jobz"; did you mean jobs?', 'line 3: --keep-inputs is "8Q", want bytes (K, M, G, T) from 0 to 1e+15',
    'line 4: "queue" is not of the form name = value', 'line 6: --log-level is "loud", want one of debug info warn error off',
    'line 5: --listen is "nowhere", want HOST:PORT with a port from 0 to 65535, or unix:/PATH',
    'line 7: --public-url is "x", want http://HOST or https://HOST. A port and a path may follow (128 bytes at most), but no query',
], 'each in a line of its own, by file, line, name, value and range';
($status, $text) = check('--config', "$dir/none.conf");
is $status, 2, 'a file that is not there is refused';
like $text, qr{/none\.conf cannot be read: No such file}, 'by name';
like +(Vt::run('--config', $dir, '--check-config'))[1], qr{^voronoid: \Q$dir\E cannot be read: Is a directory$}, 'nor is a folder';

# Flag, then variable, then file.
{
    my $path = file("queue = 0\nlog-level = debug\n");
    is((check('--config', $path, '--queue', 5))[0], 0, 'a flag wins over a line, however wrong');
    local $ENV{VORONOID_QUEUE} = '6';
    is((check('--config', $path))[0], 0, 'so does a variable');
    local $ENV{VORONOID_CONFIG} = $path;
    is((check())[0], 0, 'the file may be named by a variable');
    my $daemon = Vt->start('admin-listen' => '127.0.0.1:0', queue => 9);
    $daemon->get('/livez');
    like $daemon->{http}->get("http://$daemon->{admin}/metrics")->{content}, qr/^voronoid_queue_limit_jobs 9$/m, 'a flag wins over both';
    $daemon->{http}->get("http://$daemon->{admin}/livez");
    is $daemon->stop, 0, 'and the daemon runs';
    like $daemon->log_text, qr/"level":"debug"/, 'with what only the file says';
}

# Values in files of their own.
{
    local $ENV{VORONOID_QUEUE_FILE} = file("0\n");
    ($status, $text) = check();
    is $status, 2, 'a value in a file is checked as any other';
    like $text, qr/--queue is "0"/, 'and named';
    local $ENV{VORONOID_QUEUE} = '3';
    like +(check())[1], qr/VORONOID_QUEUE and VORONOID_QUEUE_FILE are both given/, 'a value and a file are one too many';
    delete local $ENV{VORONOID_QUEUE};
    for my $case (["12\r\n", undef], ["1\n2\n", qr/holds a control byte \(such as a line break\), want a single line/],
        ["1\0", qr/holds a control byte/], ['1' x 2000, qr/has 1024 bytes or more, want a value of at most 1023/]) {
        $ENV{VORONOID_QUEUE_FILE} = file($case->[0]);
        my ($failed, $said) = check();
        is $failed, defined $case->[1] ? 2 : 0, 'a file that holds ' . (substr($case->[0], 0, 8) =~ s/[^\d]/./gr);
        like $said, qr/VORONOID_QUEUE_FILE: $ENV{VORONOID_QUEUE_FILE} $case->[1]/, 'is named' if defined $case->[1];
    }
    $ENV{VORONOID_QUEUE_FILE} = "$dir/none";
    like +(check())[1], qr{VORONOID_QUEUE_FILE is "\Q$dir\E/none", which cannot be read: No such file}, 'one that is not there too';
}
done_testing();
